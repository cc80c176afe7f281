// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/inside/cage_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace sinew {

CageSurface::CageSurface(const Cage& cage) : all_(cage.triangles()), reach_(1e-10 * cage.size())
{
    points_.reserve(static_cast<std::size_t>(cage.vertex_count()));
    for (int v = 0; v < cage.vertex_count(); ++v)
        points_.emplace_back(cage.rest().point(v));
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

} // namespace sinew
