// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"
#include "native/methods/space/nonlinear/mls/kernels.h"
#include "native/methods/space/nonlinear/mls/weights.h"
#include "native/methods/space/weights/point_weights.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace sinew {

constexpr auto choices(MlsMaps)
{
    return std::array{Choice{"affine", MlsMaps::affine}, Choice{"similarity", MlsMaps::similarity},
                      Choice{"rigid", MlsMaps::rigid}};
}

struct MlsOptions
{
    MlsMaps maps = MlsMaps::rigid;
    double alpha = 2.0;
    std::vector<std::array<int, 2>> segments{};
    WeightPrecision precision = WeightPrecision::single_precision;

    static constexpr auto table()
    {
        using O = MlsOptions;
        return std::tuple{
            option("maps", &O::maps, Rebind::anew,
                   "that are fitted: 'rigid', 'similarity' (with one scale), or 'affine', which needs four "
                   "points that lie in no plane; else rigid maps are used, and the report says so"),
            option("alpha", &O::alpha, Rebind::anew, more_than(0),
                   "weights are distance^(-2 alpha): the larger, the nearer the handles are that count"),
            option("segments", &O::segments, Rebind::anew,
                   "None, or (s, 2) pairs of points that are handles of their own: the segment between "
                   "them is the handle instead"),
            option("precision", &O::precision, Rebind::anew, "of the stored weights: 'single' or 'double'")};
    }
};

/// Four points after the other: (numbers, 4) each, in one of the two.
struct MlsWeights
{
    std::vector<float> singles;
    std::vector<double> doubles;
};

/// Moving least squares: at each point, the map that fits the handles best, near ones the more.
///
/// S. Schaefer, T. McPhail, J. Warren. "Image Deformation Using Moving Least Squares." SIGGRAPH 2006.
/// Y. Zhu, S. Gortler. "3D Deformation Using Moving Least Squares." Harvard TR-10-07, 2007. Tutorial,
/// section 7.
///
///     f(v) = M (v - p*) + q*,   M = argmin sum_i w_i |M (p_i - p*) - (q_i - q*)|^2,   w_i = |p_i - v|^(-2
///     alpha)
///
/// with the weighted means p* and q* of the handle points at rest and posed, and M among all linear maps, the
/// similarities or the rotations. A point on a handle goes where the handle takes it, and a map of the class
/// that all handles make is reproduced. In 3D, the best rotation has no closed form:
/// operators/fits/rotation_fit.h finds it, four points at a time.
///
/// Beyond the papers: how strongly a point is held multiplies its w_i, and a place that several handles hold
/// goes to the mean of their targets; a handle of several points moves by an affine map, and its points share
/// one weight.
/// Over a surface, the sum of 1 / d^2 hardly grows towards it: with alpha = 1, far points of a region
/// outweigh those that are near, and its border tears. So alpha is 2 by default, which the papers leave open.
/// What a frame needs of it are ten numbers: its weight, and the first and second moments of its weighted
/// points. So do segments, whose moments are integrals; in 3D, these are quadratures, whose weights are
/// positive, so that all that is said above holds for segments, too.
///
/// Affine maps are fitted only if the handle points extend in space; if they lie in a plane, rotations are
/// used instead, and the report says so.
///
///   call           repeat it when ...       cost
///   constructor    the handles changed      nothing
///   bind()         the points changed       O(n c) for c handle points
///   warp()         the handles moved        O(n k) for k handles, and a rotation per point
///
/// Memory per point: 24 bytes, and 4 (single precision) or 8 per handle of one point, and ten times as much
/// per handle of several points and per segment. Rounded weights of points and of groups are other weights of
/// about the same value, so all maps are reproduced as in double precision; with segments, to 1e-7.
class Mls final : public SpaceMethodWith<MlsWeights>
{
public:
    /// \throw InvalidOption      alpha is not > 0, or no number.
    /// \throw InvalidConstraint  a segment has another end than a handle of one point, or no length.
    explicit Mls(HandlePoints handles, const MlsOptions& options = {});
    ~Mls() override;

    const HandlePoints& handles() const { return handles_; }
    /// The maps that are fitted.
    MlsMaps maps() const { return maps_; }

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;

private:
    template <class T>
    void weigh(PointsView points, std::vector<T>& weights, const Progress& progress) const;
    template <class Real>
    void move(const MlsFrame& frame, PointsView base, Real* out) const;
    bool is_single() const { return options_.precision == WeightPrecision::single_precision; }

    HandlePoints handles_;
    MlsOptions options_;
    MlsMaps maps_;
    std::string remark_;
    MlsElements elements_;
};

} // namespace sinew
