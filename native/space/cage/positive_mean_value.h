// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"
#include "native/space/cage/inside/cage_surface.h"
#include "native/space/cage/inside/outside_weights.h"

#include <memory>
#include <vector>

namespace sinew {

class VisibleCage;

struct PositiveMeanValueOptions
{
    PointWeightOptions weights;
    bool exact = true;     ///< else by `directions` rays a point: a preview
    int directions = 1024; ///< rays, in antipodal pairs: even, at least 8
    CageOutside outside = CageOutside::refuse;
};

/// Positive mean value coordinates: mean values of the part of the cage that a point sees.
///
/// Y. Lipman, J. Kopf, D. Cohen-Or, D. Levin. "GPU-assisted Positive Mean Value Coordinates for Mesh
/// Deformations." Symposium on Geometry Processing 2007. Tutorial, section 5.4.
///
/// w_v(x) is the integral of v's hat function / |p - x| over the part of the unit sphere around x where the
/// cage's first face belongs to v; weights are w_v / sum w. Non-negative, sum 1, linear precision; those of
/// MeanValue in a convex cage. Departs from the paper, which rasters the cage: what each face hides of
/// another is cut away in closed form, so the weights are exact.
///
/// Weights are continuous, yet not smooth: where an edge of the cage comes into view their gradients jump.
/// Rays instead of cuts also make the weights themselves jump, by some 1e-3 with 1024 of them.
///
///   call          cost
///   constructor   O(cage)
///   bind()        O(points x pairs of faces one behind the other), some 100 us a point and 300 concave
///   faces;
///                 by rays O(points x faces x directions), a tenth of that
class PositiveMeanValue : public CageCoordinates
{
public:
    /// \throw InvalidOption  too few directions, or an odd number of them.
    explicit PositiveMeanValue(Cage cage, const PositiveMeanValueOptions& options = {});
    ~PositiveMeanValue() override;

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    bool reaches_outside() const override { return outside_.reaches(); }

private:
    PositiveMeanValueOptions options_;
    std::unique_ptr<VisibleCage> visible_;
    CageSurface surface_;
    OutsideWeights outside_;
};

} // namespace sinew
