// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage.h"

#include <vector>

namespace sinew {

/// Finds points that lie on a cage, where coordinates by integrals over it lose their digits.
class CageSurface
{
public:
    explicit CageSurface(const Cage& cage);

    /// The first triangle that holds `point`, to 1e-10 of the cage's size; -1 for none.
    /// \param[out] hats  the values of its corners' hat functions there, non-negative, sum 1.
    int triangle_at(const Vector3& point, Vector3& hats) const;

private:
    struct Plane
    {
        Vector3 normal, corner[3], slope[3]; ///< slope: gradient of the hat of each corner
        double offset;
    };
    std::vector<Plane> planes_;
    std::vector<int> triangles_;
    double reach_;
};

/// How often the cage winds around a point: 1 inside, 0 outside; not on the cage.
double winding_number(const Cage& cage, const Vector3& point);

} // namespace sinew
