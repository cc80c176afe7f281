// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/triangle_tree.h"
#include "native/space/cage/cage.h"

#include <vector>

namespace sinew {

/// Tells where points lie to a cage: inside, outside, or on it, where coordinates by integrals over it lose
/// their digits.
class CageSurface
{
public:
    explicit CageSurface(const Cage& cage);

    /// The first triangle that holds `point`, to 1e-10 of the cage's size; -1 for none.
    /// \param[out] hats  the values of its corners' hat functions there, non-negative, sum 1.
    int triangle_at(const Vector3& point, Vector3& hats) const;

    /// How often the cage winds around a point: 1 inside, 0 outside; not on the cage.
    double winding(const Vector3& point) const { return winding_number(points_, all_, point); }

private:
    struct Plane
    {
        Vector3 normal, corner[3], slope[3]; ///< slope: gradient of the hat of each corner
        double offset;
    };
    std::vector<Vector3> points_;
    std::vector<Triangle> all_;
    std::vector<Plane> planes_;
    std::vector<int> triangles_; ///< of the planes
    double reach_;
};

} // namespace sinew
