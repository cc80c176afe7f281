// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/handles/handle_groups.h"
#include "native/handles/propagated_motions.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"

#include <string>
#include <vector>

namespace sinew {

struct SpacePropagationOptions
{
    std::vector<double> transfer{0.0, 1.0}; ///< see TransferCurve

    static constexpr auto table()
    {
        using O = SpacePropagationOptions;
        return std::tuple{
            option("transfer", &O::transfer, Rebind::anew, any_number(),
                   "(k,) values of t(s) at even steps from s = 0 to s = 1, k >= 2; None for t(s) = s")};
    }
};

/// Transformation propagation in space: the motions of the handles fade with the distance, for any points.
///
/// M. Pauly, R. Keiser, L. Kobbelt, M. Gross. "Shape Modeling with Point-Sampled Geometry." SIGGRAPH 2003.
/// Tutorial, section 5.2.
///
/// As methods/surface/linear/propagation.h, with straight distances d_h from the nearest point of each
/// handle:
///
///     s_h = (1 / d_h) / sum_g (1 / d_g),      s = d_F / (d_F + d_H) for one handle and what is fixed
///
/// A point that is held by a weight w < 1 is (1 - w) / w spacings farther away: the size of all handles over
/// the root of how many points they have. Rotation, scale and move are damped apart by t(s), about the centre
/// of the handle. Points of a handle go where it takes them. It needs no surface, so gaps, loose parts,
/// curves and point clouds are no obstacle; but it knows none either, so a handle reaches across a gap as far
/// as along the shape.
///
/// Departs from the paper: several handles are blended as on a surface. With t(s) = s, an affine map of all
/// handles together is reproduced.
///
///   call           repeat it when ...       cost
///   constructor    the handles changed      nothing
///   bind()         the points changed       O(log c) for each point and handle of c points
///   warp()         the handles moved        O(n k) for k handles
///
/// Memory per point: 24 bytes, and 4 for each handle but one.
///
/// The weights are (n, handles - 1) shares.
class SpacePropagation final : public SpaceMethodWith<std::vector<float>>
{
public:
    /// \throw InvalidOption  `transfer` has less than two values, or one that is not finite.
    explicit SpacePropagation(HandlePoints handles, const SpacePropagationOptions& options = {});
    ~SpacePropagation() override;

    const HandlePoints& handles() const { return handles_; }

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;

private:
    template <class Real>
    void move(PointsView control, PointsView base, Real* out) const;
    /// s of all handles at a point: of all but the last one they are stored.
    double share(int point, int handle) const;

    HandlePoints handles_;
    SpacePropagationOptions options_;
    TransferCurve transfer_;
    HandleGroups groups_;       ///< one, of all handles
    std::vector<Vector3> means_; ///< of the points of each handle
};

} // namespace sinew
