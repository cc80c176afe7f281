// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/deformation_graph.h"

#include "native/core/parallel.h"
#include "native/mesh/trees/triangle_tree.h"
#include "native/methods/space/nonlinear/handles/handle_reach.h"

#include <Eigen/LU>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

namespace sinew {

namespace {

constexpr double close_parts = 1.5; ///< radii
constexpr int links = 3; ///< pairs that join a piece of the graph to the next one
constexpr double tie = 1e-5; ///< lengths that differ by this share are equal but for rounding

using Share = BlendedMaps::Share;

/// Barycentric coordinates of a point of a triangle.
Vector3 coordinates(const Corners& corners, const Vector3& at)
{
    const Vector3 u = corners[1] - corners[0], v = corners[2] - corners[0], w = at - corners[0];
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
    if (!(det > 0.0))
        return {1.0, 0.0, 0.0};
    const double b = std::clamp((vv * u.dot(w) - uv * v.dot(w)) / det, 0.0, 1.0),
                 c = std::clamp((uu * v.dot(w) - uv * u.dot(w)) / det, 0.0, 1.0 - b);
    return {1.0 - b - c, b, c};
}

} // namespace

struct DeformationGraph::Pieces
{
    std::vector<int> parent;
    explicit Pieces(int count) : parent(static_cast<std::size_t>(count))
    {
        std::iota(parent.begin(), parent.end(), 0);
    }
    int of(int i)
    {
        while (parent[i] != i)
            i = parent[i] = parent[parent[i]];
        return i;
    }
    void join(int a, int b) { parent[of(a)] = of(b); }
};

DeformationGraph::DeformationGraph(const SurfaceMesh& mesh, int wanted, const Progress& progress)
    : mesh_(mesh), near_(mesh, wanted, progress), places_(mesh.points()(near_.nodes(), Eigen::all))
{
    connect(progress);
    double sum = 0.0;
    for (const auto& [a, b] : edges_)
        sum += (places_.row(a) - places_.row(b)).norm();
    if (sum > 0.0)
        edge_length_ = sum / static_cast<double>(edges_.size());
}

void DeformationGraph::connect(const Progress& progress)
{
    progress.tick(0.7, "connecting nodes");
    std::vector<std::vector<int>> later(static_cast<std::size_t>(size())); // of each node, those after it
    const auto add = [&](int a, int b) {
        std::vector<int>& own = later[std::min(a, b)];
        if (std::ranges::find(own, std::max(a, b)) == own.end())
            own.push_back(std::max(a, b));
    };
    for (const auto& [a, b] : near_.pairs())
        if ((places_.row(a) - places_.row(b)).norm() <= NearNodes::reach * near_.radius())
            add(a, b);
    for (int v = 0; v < mesh_.vertex_count(); ++v) {
        if (near_.is_loose(v))
            continue;
        const std::vector<Share> own = near_.shares(v);
        for (const Share& a : own)
            for (const Share& b : own)
                if (a.map < b.map)
                    add(a.map, b.map);
    }
    const auto on_large_part = [&](int j) { return near_.is_on_surface(near_.nodes()[j]); };
    for (int a = 0; a < size(); ++a)
        for (int b = a + 1; b < size(); ++b)
            if (on_large_part(a) && on_large_part(b) &&
                near_.part(near_.nodes()[a]) != near_.part(near_.nodes()[b]) &&
                (places_.row(a) - places_.row(b)).norm() <= close_parts * near_.radius())
                add(a, b);
    for (int a = 0; a < size(); ++a) {
        std::ranges::sort(later[a]);
        for (const int b : later[a])
            edges_.push_back({a, b});
    }
    join_parts();
}

void DeformationGraph::join_parts()
{
    Pieces pieces(size());
    for (const auto& [a, b] : edges_)
        pieces.join(a, b);
    for (const bool within_parts : {true, false})
        for (int first = 0; first < size(); ++first)
            while (join_next(pieces, pieces.of(first), within_parts))
                ;
    for (int j = 0; j < size(); ++j)
        pieces_.push_back(pieces.of(j));
    std::ranges::sort(edges_);
}

bool DeformationGraph::join_next(Pieces& pieces, int first, bool within_part)
{
    const auto part = [&](int j) { return near_.part(near_.nodes()[j]); };
    std::vector<int> inside, outside;
    for (int j = 0; j < size(); ++j)
        if (pieces.of(j) == first)
            inside.push_back(j);
        else if (!within_part || part(j) == part(first))
            outside.push_back(j);
    std::vector<std::tuple<double, int, int>> ways;
    for (const int a : inside)
        for (const int b : outside)
            ways.emplace_back((places_.row(a) - places_.row(b)).norm(), a, b);
    const auto shortest = [&] { // of those that are as short as any, the first
        const double least = std::get<0>(*std::ranges::min_element(ways));
        return std::ranges::find_if(ways,
                                    [&](const auto& way) { return std::get<0>(way) <= least * (1.0 + tie); });
    };
    if (ways.empty())
        return false;
    const int next = pieces.of(std::get<2>(*shortest()));
    std::erase_if(outside, [&](int b) { return pieces.of(b) != next; });
    if (!within_part && !mesh_.triangles().empty() &&
        !are_near(std::get<0>(*shortest()), places_(inside, Eigen::all), places_(outside, Eigen::all)))
        return false;
    std::erase_if(ways, [&](const auto& way) { return pieces.of(std::get<2>(way)) != next; });
    for (int k = 0; k < links && !ways.empty(); ++k) {
        const auto at = shortest();
        const auto [length, a, b] = *at;
        edges_.push_back({std::min(a, b), std::max(a, b)});
        ways.erase(at);
    }
    pieces.join(first, next);
    return true;
}

std::vector<std::vector<Share>> DeformationGraph::shares(PointsView points) const
{
    const int count = static_cast<int>(points.rows());
    std::vector<std::vector<Share>> result(static_cast<std::size_t>(count));
    std::vector<int> vertex(static_cast<std::size_t>(count), -1);
    const Points& own = mesh_.points();
    if (points.rows() == own.rows() && points == own) {
        std::iota(vertex.begin(), vertex.end(), 0);
    } else {
        std::map<std::array<double, 3>, int> at;
        for (int v = mesh_.vertex_count() - 1; v >= 0; --v)
            at[{own(v, 0), own(v, 1), own(v, 2)}] = v;
        for (int i = 0; i < count; ++i)
            if (const auto found = at.find({points(i, 0), points(i, 1), points(i, 2)}); found != at.end())
                vertex[i] = found->second;
    }
    std::optional<TriangleTree> tree;
    std::vector<Vector3> corners;
    if (std::ranges::any_of(vertex, [](int v) { return v < 0; }) && !mesh_.triangles().empty()) {
        for (int v = 0; v < mesh_.vertex_count(); ++v)
            corners.push_back(mesh_.point(v));
        tree.emplace(corners, mesh_.triangles());
    }
    parallel_for(
        count,
        [&](int i) {
            if (vertex[i] >= 0) {
                result[i] = near_.shares(vertex[i]);
                return;
            }
            const Vector3 place = points.row(i).transpose();
            if (!tree || tree->empty()) {
                result[i] = near_.straight_shares(place);
                return;
            }
            const TriangleTree::Place closest = tree->closest_place(place);
            const Triangle& triangle = mesh_.triangles()[closest.triangle];
            const Vector3 parts = coordinates(corners_of(corners, triangle), closest.point);
            std::map<int, double> sums;
            for (int k = 0; k < 3; ++k)
                for (const Share& share : near_.shares(triangle[k]))
                    sums[share.map] += parts[k] * share.weight;
            for (const auto& [node, weight] : sums)
                if (weight > 0.0)
                    result[i].push_back({node, weight});
        },
        256);
    return result;
}

} // namespace sinew
