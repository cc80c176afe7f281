// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace sinew {

namespace {

Vector3 doubled_area_vector(const std::vector<Vector3>& points, const Triangle& t)
{
    return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
}

/// The directed sides of triangles that no other triangle runs along the other way round.
std::vector<std::array<int, 2>> border_of(const std::vector<Triangle>& triangles)
{
    std::vector<std::array<int, 2>> sides;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k)
            sides.push_back({t[k], t[(k + 1) % 3]});
    std::ranges::sort(sides);
    std::vector<std::array<int, 2>> border;
    for (const auto& [from, to] : sides)
        if (!std::ranges::binary_search(sides, std::array{to, from}))
            border.push_back({from, to});
    return border;
}

} // namespace

int Part::centre() const
{
    std::vector<double> weights(points.size(), 0.0);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int v : triangles[t])
            weights[v] += areas[t];
    if (area == 0.0)
        weights.assign(points.size(), 1.0);
    Vector3 sum = Vector3::Zero();
    for (std::size_t v = 0; v < points.size(); ++v)
        sum += weights[v] * (points[v] - points[0]); // from a point nearby: far from the origin, too
    const Vector3 centroid = points[0] + sum / std::accumulate(weights.begin(), weights.end(), 0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3& point : points)
        least = std::min(least, (point - centroid).squaredNorm());
    const auto nearest = std::ranges::find_if(points, [&](const Vector3& point) { // but for rounding
        return (point - centroid).squaredNorm() <= least * (1 + 1e-9);
    });
    return static_cast<int>(nearest - points.begin());
}

std::vector<Triangle> Part::ways() const
{
    std::vector<Triangle> all = triangles;
    all.insert(all.end(), bridges.begin(), bridges.end());
    return all;
}

std::vector<Part> parts_of(const SurfaceMesh& mesh, const Components& components)
{
    std::vector<Part> parts(components.count);
    std::vector<int> local(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        Part& part = parts[components.labels[v]];
        local[v] = static_cast<int>(part.vertices.size());
        part.vertices.push_back(v);
        part.points.push_back(mesh.point(v));
        part.box.extend(mesh.point(v));
    }
    for (const Triangle& t : mesh.triangles()) {
        Part& part = parts[components.labels[t[0]]];
        part.triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
        part.areas.push_back(doubled_area_vector(part.points, part.triangles.back()).norm() / 2);
        part.area += part.areas.back();
    }
    return parts;
}

ClosedPart::ClosedPart(const Part& part) : points(part.points), triangles(part.triangles)
{
    const std::vector<std::array<int, 2>> border = border_of(part.triangles);
    std::map<int, int> loops; // a vertex of the border -> another one of its loop, at last the first
    const auto first = [&](int v) {
        while (loops.at(v) != v)
            v = loops.at(v);
        return v;
    };
    for (const auto& [from, to] : border) {
        loops.try_emplace(from, from);
        loops.try_emplace(to, to);
        const auto [low, high] = std::minmax({first(from), first(to)});
        loops[high] = low;
    }
    struct Middle
    {
        Vector3 sum = Vector3::Zero();
        int sides = 0, vertex = -1;
    };
    std::map<int, Middle> middles;
    for (const auto& [from, to] : border) {
        Middle& middle = middles[first(from)];
        middle.sum += (points[from] + points[to]) / 2;
        ++middle.sides;
    }
    for (auto& [vertex, middle] : middles) {
        middle.vertex = static_cast<int>(points.size());
        points.emplace_back(middle.sum / middle.sides);
    }
    for (const auto& [from, to] : border)
        triangles.push_back({to, from, middles.at(first(from)).vertex});
}

double ClosedPart::thickness() const
{
    const Vector3 from = points[0];
    double volume = 0.0, area = 0.0;
    for (const Triangle& t : triangles) {
        const Vector3 doubled = doubled_area_vector(points, t);
        volume += doubled.dot(points[t[0]] - from) / 6;
        area += doubled.norm() / 2;
    }
    return area > 0.0 ? 6 * std::abs(volume) / area : 0.0;
}

} // namespace sinew
