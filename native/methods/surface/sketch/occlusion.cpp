// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/occlusion.h"

#include <algorithm>

namespace sinew {

namespace {

constexpr double blind = 2.0; ///< edge lengths before a point in which nothing hides it

std::vector<Vector3> places(const SurfaceMesh& mesh)
{
    std::vector<Vector3> found;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        found.push_back(mesh.point(v));
    return found;
}

std::vector<double> longest_edges(const SurfaceMesh& mesh)
{
    std::vector<double> longest(mesh.vertex_count(), 0.0);
    for (const Triangle& t : mesh.triangles())
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            const double length = (mesh.point(a) - mesh.point(b)).norm();
            longest[a] = std::max(longest[a], length);
            longest[b] = std::max(longest[b], length);
        }
    return longest;
}

} // namespace

Occlusion::Occlusion(const SurfaceMesh& mesh, const SketchView& view)
    : mesh_(mesh), view_(view), tree_(places(mesh), mesh.triangles()), longest_(longest_edges(mesh)),
      beyond_(2 * (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).norm())
{
}

bool Occlusion::hides(const LinePoint& point) const
{
    const Vector3 x = point.on(sinew::view(mesh_.points()));
    const Vector3 way = view_.eye ? view_.toward(x) : Vector3(beyond_ * view_.toward(x));
    const double length = way.norm(), skipped = blind * std::max(longest_[point.a], longest_[point.b]);
    return skipped < length && tree_.meets(x + skipped / length * way, x + way);
}

} // namespace sinew
