// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/surface_fronts.h"

#include "native/core/parallel.h"

namespace sinew {

SurfaceFronts::SurfaceFronts(const SurfaceMesh& mesh)
    : offsets_(static_cast<std::size_t>(mesh.vertex_count()) + 1, 0),
      margins_(static_cast<std::size_t>(mesh.vertex_count()), 0.0F)
{
    const std::vector<Triangle>& triangles = mesh.triangles();
    for (const Triangle& triangle : triangles)
        for (const int v : triangle)
            ++offsets_[v + 1];
    for (std::size_t v = 1; v < offsets_.size(); ++v)
        offsets_[v] += offsets_[v - 1];
    wedges_.resize(offsets_.back());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (const Triangle& triangle : triangles)
        for (int k = 0; k < 3; ++k)
            wedges_[next[triangle[k]]++].to = {triangle[(k + 1) % 3], triangle[(k + 2) % 3]};
    parallel_for(mesh.vertex_count(), [&](int v) {
        for (int k = offsets_[v]; k < offsets_[v + 1]; ++k) {
            Wedge& wedge = wedges_[k];
            const Vector3 sides[] = {mesh.point(wedge.to[0]) - mesh.point(v),
                                     mesh.point(wedge.to[1]) - mesh.point(v)};
            for (const int one : {0, 1}) {
                const double length = sides[one].norm(), other = sides[1 - one].norm();
                const double along = other > 0.0 ? sides[one].dot(sides[1 - one]) / other : 0.0;
                wedge.length[one] = static_cast<float>(length);
                wedge.along[one] = static_cast<float>(along);
                wedge.height[one] = static_cast<float>(
                    other > 0.0 ? (sides[one] - along / other * sides[1 - one]).norm() : length);
                margins_[v] = std::max(margins_[v], 2.0F * wedge.length[one]);
            }
        }
    });
}

} // namespace sinew
