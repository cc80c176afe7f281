// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace sinew {

CageSurface::CageSurface(const Cage& cage) : reach_(1e-10 * cage.size())
{
    for (std::size_t t = 0; t < cage.triangles().size(); ++t) {
        Plane plane;
        for (int k = 0; k < 3; ++k)
            plane.corner[k] = cage.rest().point(cage.triangles()[t][k]);
        const Vector3 area = (plane.corner[1] - plane.corner[0]).cross(plane.corner[2] - plane.corner[0]);
        if (!(area.norm() > 1e-16 * cage.size() * cage.size()))
            continue;
        plane.normal = area.normalized();
        plane.offset = plane.normal.dot(plane.corner[0]);
        for (int k = 0; k < 3; ++k)
            plane.slope[k] =
                plane.normal.cross(plane.corner[(k + 2) % 3] - plane.corner[(k + 1) % 3]) / area.norm();
        planes_.push_back(plane);
        triangles_.push_back(static_cast<int>(t));
    }
}

int CageSurface::triangle_at(const Vector3& point, Vector3& hats) const
{
    for (std::size_t t = 0; t < planes_.size(); ++t) {
        const Plane& plane = planes_[t];
        if (!(std::abs(plane.normal.dot(point) - plane.offset) <= reach_))
            continue;
        bool holds = true;
        for (int k = 0; k < 3; ++k) {
            hats[k] = plane.slope[k].dot(point - plane.corner[(k + 1) % 3]);
            holds = holds && hats[k] >= -reach_ * plane.slope[k].norm();
        }
        if (holds) {
            hats = hats.cwiseMax(0.0);
            hats /= hats.sum();
            return triangles_[t];
        }
    }
    return -1;
}

double winding_number(const Cage& cage, const Vector3& point)
{
    // Half the solid angle of a triangle [Van Oosterom & Strackee 1983].
    double sum = 0.0;
    for (const Triangle& triangle : cage.triangles()) {
        std::array<Vector3, 3> u;
        for (int k = 0; k < 3; ++k)
            u[k] = cage.rest().point(triangle[k]) - point;
        const double a = u[0].norm(), b = u[1].norm(), c = u[2].norm();
        sum += std::atan2(u[0].dot(u[1].cross(u[2])),
                          a * b * c + u[0].dot(u[1]) * c + u[1].dot(u[2]) * a + u[2].dot(u[0]) * b);
    }
    return sum / (2.0 * std::numbers::pi);
}

} // namespace sinew
