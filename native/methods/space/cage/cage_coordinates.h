// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"
#include "native/methods/space/weights/linear_method.h"

#include <utility>

namespace sinew {

/// What every cage method shares: its control is the vertices of a closed mesh.
///
///   call          repeat it when ...            cost
///   constructor   the rest cage changed         O(cage)
///   bind()        the points changed            O(points x cage)
///   warp()        the cage moved                one (n, k) x (k, 3) product
class CageCoordinates : public LinearSpaceMethod
{
public:
    static constexpr bool takes_flat = false; ///< whether the cage may be flat
    const Cage& cage() const { return cage_; }

protected:
    CageCoordinates(Cage cage, const PointWeightOptions& options)
        : LinearSpaceMethod("cage", options), cage_(std::move(cage))
    {
    }

    PointsView rest_control() const override { return view(cage_.given().points()); }
    PointsView normalized(PointsView points, Points& storage) const override
    {
        return cage_.frame().in(points, storage);
    }
    void check_control(PointsView control) const override { cage_.check_pose(control); }
    /// "cage", "precision" and "threshold".
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;

private:
    Cage cage_;
};

} // namespace sinew
