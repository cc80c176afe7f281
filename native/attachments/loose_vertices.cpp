// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/loose_vertices.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew {

namespace {

constexpr int grain = 256;
constexpr int most_steps = 32; ///< of a walk: a part may be finer here than elsewhere
constexpr double farthest = 8.0; ///< in edges of the host

/// Goes from vertex to vertex over the host, as far along a direction as it gets, or until `distance`.
int walk(const HostSurface& host, int from, const Vector3& origin, const Vector3& direction, double distance)
{
    const std::vector<Vector3>& points = host.part().points;
    int at = from;
    double reached = direction.dot(points[at] - origin);
    for (int step = 0; step < most_steps && reached < distance; ++step) {
        const int before = at;
        for (int t : host.around(before))
            for (int v : host.triangles()[t])
                if (const double along = direction.dot(points[v] - origin); along > reached) {
                    reached = along;
                    at = v;
                }
        if (at == before)
            break;
    }
    return at;
}

/// What a triangle is like: its normal, as long as its doubled area, and its least height.
struct Shape
{
    Vector3 normal;
    double height = 0.0, longest = 0.0;

    Shape(const HostSurface& host, const Triangle& t)
    {
        const Corners p = corners_of(host.part().points, t);
        normal = (p[1] - p[0]).cross(p[2] - p[0]);
        for (int k = 0; k < 3; ++k)
            longest = std::max(longest, (p[(k + 1) % 3] - p[k]).norm());
        if (longest > 0.0)
            height = normal.norm() / longest;
    }
};

} // namespace

Triangle carriers_of(const HostSurface& host, const TriangleTree::Place& place, const Vector3& vertex)
{
    const Triangle& own = host.triangles()[place.triangle];
    const Shape beneath(host, own);
    const double above = (vertex - place.point).norm();
    if (above <= beneath.height)
        return own;
    const Vector3 normal = beneath.normal.normalized();
    const Corners corners = corners_of(host.part().points, own);
    const Vector3 u = (corners[1] - corners[0]).normalized(), v = normal.cross(u);
    double distance = std::clamp(above, host.spacing(), farthest * host.spacing());
    while (distance > 0.25 * host.spacing()) {
        Triangle found{};
        for (int k = 0; k < 3; ++k) {
            const double angle = 2 * std::numbers::pi * k / 3;
            const Vector3 direction = std::cos(angle) * u + std::sin(angle) * v;
            const auto nearest = std::ranges::max_element(
                corners, {}, [&](const Vector3& corner) { return direction.dot(corner); });
            found[k] = walk(host, own[nearest - corners.begin()], place.point, direction, distance);
        }
        // Around a sharp edge, or where the host ends, they may be no good base.
        const Shape shape(host, found);
        if (shape.height > 0.2 * shape.longest && shape.normal.dot(normal) > 0.7 * shape.normal.norm())
            return found;
        distance /= 2;
    }
    return own;
}

void LooseVertices::add(int vertex, const Triangle& corners)
{
    const int lane = size_++ % 4;
    if (lane == 0)
        slots_.emplace_back();
    for (int other = lane; other < 4; ++other) { // the last slot may stay incomplete
        slots_.back().vertices[other] = vertex;
        for (int k = 0; k < 3; ++k)
            slots_.back().corners[k][other] = corners[k];
    }
}

void LooseVertices::measure(const PointsView& points)
{
    widest_kernels<FrameKernels>().place(slots_.data(), static_cast<int>(slots_.size()), points.data());
}

void LooseVertices::move(const std::optional<PointsView>& incoming, Points& positions) const
{
    parallel_chunks(static_cast<int>(slots_.size()), grain, [&](int begin, int end) {
        widest_kernels<FrameKernels>().ride(&slots_[begin], end - begin,
                                            incoming ? incoming->data() : nullptr, positions.data());
    });
}

} // namespace sinew
