// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/shapes.h"

#include <cmath>
#include <numbers>

/// Two long legs side by side that join at the top: what straight distances glue together.
namespace sinew::legs {

inline constexpr double length = 10.0, gap = 0.4;

/// Which leg a point is on: -1 or 1, and 0 where they join.
inline int side(const Vector3& p)
{
    if (p.z() > -2.0)
        return 0;
    return p.x() < 0 ? -1 : 1;
}

/// A bar that is bent by half a turn about a thin gap.
inline SurfaceMesh pair()
{
    SurfaceMesh mesh = shapes::bar(60, 3);
    Points points = mesh.points();
    const double across = 1.0, radius = gap / 2 + across / 2, arc = std::numbers::pi * radius;
    const double whole = 2 * length + arc;
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const double s = points(v, 0) / 60 * whole, u = across * points(v, 1) / 3,
                     w = across * points(v, 2) / 3;
        if (s < length)
            points.row(v) << -(radius + u), w, s - length;
        else if (s > length + arc)
            points.row(v) << radius + u, w, length + arc - s;
        else {
            const double angle = std::numbers::pi * (1 - (s - length) / arc);
            points.row(v) << (radius + u) * std::cos(angle), w, (radius + u) * std::sin(angle);
        }
    }
    return shapes::moved(mesh, points);
}

} // namespace sinew::legs
