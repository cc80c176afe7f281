// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/trees/triangle_tree.h"
#include "native/methods/space/cage/cage.h"

#include <vector>

namespace sinew {

/// Finds out whether points are inside, outside, or on a cage. On the cage, coordinates that are integrals
/// over it lose their digits.
class CageSurface
{
public:
    explicit CageSurface(const Cage& cage);

    /// The first triangle that a point lies on, to 1e-10 of the cage's size; -1 for none.
    /// \param[out] hats  the hat values of its corners at the point; they are not negative and sum to 1.
    int triangle_at(const Vector3& point, Vector3& hats) const;

    /// How often the cage winds around a point that is not on it: 1 inside, 0 outside.
    double winding(const Vector3& point) const { return winding_number(points_, all_, point); }

private:
    struct Plane
    {
        Vector3 normal, corner[3], slope[3]; ///< `slope` has the gradients of the hats of the corners
        double offset;
    };
    std::vector<Vector3> points_;
    std::vector<Triangle> all_;
    std::vector<Plane> planes_;
    std::vector<int> triangles_; ///< the triangle of each plane
    double reach_;
};

} // namespace sinew
