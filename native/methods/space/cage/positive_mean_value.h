// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/cage/cage_coordinates.h"
#include "native/methods/space/cage/inside/cage_surface.h"
#include "native/methods/space/cage/inside/outside_weights.h"

#include <memory>
#include <vector>

namespace sinew {

class VisibleCage;

struct PositiveMeanValueOptions
{
    PointWeightOptions weights;
    bool exact = true;
    int directions = 1024;
    CageOutside outside = CageOutside::refuse;

    static constexpr auto table()
    {
        using O = PositiveMeanValueOptions;
        return std::tuple{
            option("exact", &O::exact, Rebind::anew,
                   "whether to cut hidden parts away exactly; False takes rays, a preview whose weights "
                   "jump by some 1e-3"),
            option("directions", &O::directions, Rebind::anew, between(8, 1 << 20),
                   "rays per point, an even number"),
            option("outside", &O::outside, Rebind::anew,
                   "points outside: 'error' names them, 'mean_value' gives them mean value weights")};
    }
};

/// Positive mean value coordinates: mean values of the part of the cage that a point sees.
///
/// Y. Lipman, J. Kopf, D. Cohen-Or, D. Levin. "GPU-assisted Positive Mean Value Coordinates for Mesh
/// Deformations." Symposium on Geometry Processing 2007. Tutorial, section 5.4.
///
/// w_v(x) is the integral of v's hat function / |p - x| over the part of the unit sphere around x where the
/// first face of the cage that is seen has v as a corner; the weights are w_v / sum w. They are not negative,
/// sum to 1 and have linear precision; in a convex cage they are those of MeanValue. Departs from the paper,
/// which renders the cage to an image: the part of a face that another one hides is cut away in closed form,
/// so the weights are exact.
///
/// The weights are continuous but not smooth: where an edge of the cage comes into view, their gradients
/// jump. With rays, the weights themselves jump, too, by some 1e-3 for 1024 rays.
///
///   call          cost
///   constructor   O(cage)
///   bind()        O(points x pairs of faces of which one hides the other), some 100 us per point in a
///   concave
///                 cage of 300 faces; by rays O(points x faces x directions), a tenth of that
class PositiveMeanValue : public CageCoordinates
{
public:
    /// \throw InvalidOption  there are fewer than 8 directions, or an odd number of them.
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
