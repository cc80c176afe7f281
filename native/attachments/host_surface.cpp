// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/host_surface.h"

#include "native/caging/mirror_plane.h"

#include <algorithm>
#include <cmath>

namespace sinew {

Vector3 barycentric(const Corners& triangle, const Vector3& point)
{
    const auto& [a, b, c] = triangle;
    const Vector3 normal = (b - a).cross(c - a);
    const double square = normal.squaredNorm();
    if (!(square > 0.0))
        return {1.0, 0.0, 0.0};
    const double v = (point - a).cross(c - a).dot(normal) / square,
                 w = (b - a).cross(point - a).dot(normal) / square;
    return {1.0 - v - w, v, w};
}

HostSurface::HostSurface(const Part& part) : part_(&part), offsets_(part.points.size() + 1, 0)
{
    const double least = 1e-10 * std::ranges::max(part.areas);
    double sum = 0.0;
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
        if (part.areas[i] <= least)
            continue;
        const Triangle& t = part.triangles[i];
        triangles_.push_back(t);
        areas_.push_back(part.areas[i]);
        sum += part.areas[i];
        centres_.emplace_back((part.points[t[0]] + part.points[t[1]] + part.points[t[2]]) / 3);
        for (int v : t)
            ++offsets_[v + 1];
    }
    spacing_ = std::sqrt(2 * sum / static_cast<double>(triangles_.size()));
    for (std::size_t v = 0; v < part.points.size(); ++v)
        offsets_[v + 1] += offsets_[v];
    around_.resize(3 * triangles_.size());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
        for (int v : triangles_[t])
            around_[next[v]++] = t;
}

void HostSurface::find_mirror_plane()
{
    constexpr double tolerance = 1e-3;
    const Vector3 middle = part_->box.center();
    const double size = part_->extent();
    std::vector<Vector3> points;
    for (const Vector3& point : part_->points)
        points.emplace_back((point - middle) / size);
    const TriangleTree tree(points, triangles_);
    const MirrorPlane plane =
        MirrorTest(points, static_cast<int>(points.size()), tree).best(-middle / size, -1, tolerance);
    if (plane.deviation <= tolerance) {
        mirror_axis_ = plane.axis;
        mirror_place_ = middle[plane.axis] + size * plane.offset;
    }
}

Triangle HostSurface::mirror_image(const Triangle& corners) const
{
    const std::vector<Vector3>& points = part_->points;
    const auto image_of = [&](int vertex) {
        const Vector3 wanted = mirror_image(points[vertex]);
        const Triangle& there = triangles_[tree_->closest_place(wanted).triangle];
        return *std::ranges::min_element(there, {},
                                         [&](int v) { return (points[v] - wanted).squaredNorm(); });
    };
    const Triangle image{image_of(corners[0]), image_of(corners[2]), image_of(corners[1])};
    if (image[0] != image[1] && image[1] != image[2] && image[2] != image[0])
        return image;
    const Vector3 middle = (points[corners[0]] + points[corners[1]] + points[corners[2]]) / 3;
    return triangles_[tree_->closest_place(mirror_image(middle)).triangle];
}

bool HostSurface::lies_on_mirror_plane(const Part& part) const
{
    constexpr double tolerance = 1e-2;
    if (mirror_axis_ < 0)
        return false;
    double sum = 0.0;
    for (const Vector3& point : part.points)
        sum += point[mirror_axis_] - mirror_place_;
    const double off = std::max(std::abs(sum / static_cast<double>(part.points.size())),
                                std::abs(part.box.center()[mirror_axis_] - mirror_place_));
    return off <= tolerance * part.extent();
}

} // namespace sinew
