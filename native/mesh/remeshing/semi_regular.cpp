// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/semi_regular.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/remeshing/decimation.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace sinew {

namespace {

constexpr double most_triangles = 2e7, fewest_faces = 500.0; // of a base that nobody asks for

/// What new vertices are put onto.
class Ground
{
public:
    explicit Ground(const Manifold& cut) : tree_(cut.points, cut.triangles)
    {
        for (const Manifold::Line& line : cut.lines)
            lines_.push_back({cut.points[line.edge[0]], cut.points[line.edge[1]]});
    }

    /// Puts some points onto the lines, or else onto the surface.
    void project(std::vector<Vector3>& points, const std::vector<int>& which,
                 const std::vector<char>& on_line) const
    {
        std::vector<Vector3> asked;
        for (int v : which)
            asked.push_back(points[v]);
        const std::vector<int> closest = closest_lines(lines_, asked);
        parallel_for(
            static_cast<int>(asked.size()),
            [&](int i) {
                points[which[i]] = on_line[which[i]] && closest[i] >= 0
                                       ? closest_on(lines_[closest[i]], asked[i])
                                       : tree_.closest(asked[i]);
            },
            512);
    }

private:
    TriangleTree tree_;
    std::vector<std::array<Vector3, 2>> lines_;
};

/// Splits each triangle into four. New vertices lie in the middle of the edges.
void split(Remeshed& mesh, std::vector<char>& on_line)
{
    std::map<Edge, char> kept;
    for (const auto& [a, b] : mesh.lines)
        kept.emplace(Edge{std::min(a, b), std::max(a, b)}, 1);
    std::map<Edge, int> middles;
    std::vector<Triangle> finer;
    std::vector<Edge> lines;
    for (const Triangle& t : mesh.triangles) {
        Triangle m;
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            const Edge edge{std::min(a, b), std::max(a, b)};
            const auto [found, is_new] = middles.emplace(edge, static_cast<int>(mesh.points.size()));
            m[k] = found->second;
            if (!is_new)
                continue;
            mesh.points.push_back(0.5 * (mesh.points[edge[0]] + mesh.points[edge[1]]));
            on_line.push_back(kept.contains(edge));
            if (on_line.back()) {
                lines.push_back({edge[0], m[k]});
                lines.push_back({m[k], edge[1]});
            }
        }
        finer.insert(finer.end(), {{t[0], m[0], m[2]}, {m[0], t[1], m[1]}, {m[2], m[1], t[2]}, m});
    }
    mesh.triangles = std::move(finer);
    mesh.lines = std::move(lines);
}

/// Puts the vertices from the middles on onto the surface. Where a part of a triangle would then look to the
/// other side or lose its area, its vertices go only a half of the way, a quarter and so on, and at last stay in the middles.
void fit(Remeshed& mesh, const std::vector<Vector3>& middles, const Ground& ground,
         const std::vector<char>& on_line)
{
    constexpr double least_way = 1.0 / 32.0, least_area = 0.01; // of what they were
    const std::size_t first = mesh.points.size() - middles.size();
    const auto normal = [&](const Triangle& t, const auto& place) -> Vector3 {
        return (place(t[1]) - place(t[0])).cross(place(t[2]) - place(t[0]));
    };
    const auto flat = [&](int v) {
        return v < static_cast<int>(first) ? mesh.points[v] : middles[v - first];
    };
    const auto fitted = [&](int v) { return mesh.points[v]; };
    std::vector<double> ways(middles.size(), 1.0);
    std::vector<int> moving(middles.size());
    std::iota(moving.begin(), moving.end(), static_cast<int>(first));
    ground.project(mesh.points, moving, on_line);
    const std::vector<Vector3> goals(mesh.points.begin() + static_cast<std::ptrdiff_t>(first),
                                     mesh.points.end());
    while (true) {
        std::set<int> turned;
        for (const Triangle& t : mesh.triangles)
            if (const Vector3 was = normal(t, flat);
                !(was.dot(normal(t, fitted)) > least_area * was.squaredNorm()))
                for (int v : t)
                    if (v >= static_cast<int>(first) && ways[v - first] > 0.0)
                        turned.insert(v);
        if (turned.empty())
            return;
        moving.clear();
        for (int v : turned) {
            double& way = ways[v - first];
            way = way > least_way ? 0.5 * way : 0.0;
            mesh.points[v] = middles[v - first] + way * (goals[v - first] - middles[v - first]);
            if (way > 0.0)
                moving.push_back(v);
        }
        ground.project(mesh.points, moving, on_line);
    }
}

} // namespace

SemiRegular semi_regular(const SurfaceMesh& mesh, const SemiRegularOptions& options,
                         const std::vector<Edge>& given, const Progress& progress)
{
    if (options.levels < 1 || options.levels > 10)
        throw InvalidOption("levels must be 1 to 10");
    if (options.base_faces != 0 && options.base_faces < 4)
        throw InvalidOption("base_faces must be at least 4");
    progress.tick(0.0, "decimating");
    Manifold cut(mesh, given);
    const double share = std::pow(4.0, -options.levels), present = static_cast<double>(cut.triangles.size());
    const double least = std::clamp(0.25 * present, 4.0, fewest_faces);
    const int wanted =
        options.base_faces > 0 ? options.base_faces : static_cast<int>(std::max(least, share * present));
    SemiRegular made;
    made.finest = decimated(cut, wanted, options.angle, progress);
    Remeshed& finest = made.finest;
    if (static_cast<double>(finest.triangles.size()) / share > most_triangles)
        throw InvalidOption("levels: the last one would have more than 20 million triangles");
    join_cuts(finest, mesh, cut);
    const Ground ground(cut);
    std::vector<char> on_line(finest.points.size(), 0);
    for (const Edge& edge : finest.lines)
        for (int v : edge)
            on_line[v] = 1;
    std::vector<int> all(finest.points.size());
    std::iota(all.begin(), all.end(), 0);
    ground.project(finest.points, all, on_line);
    made.base = finest.triangles;
    made.counts.push_back(static_cast<int>(finest.points.size()));
    for (int level = 0; level < options.levels; ++level) {
        progress.tick(0.8, "fitting");
        const std::size_t first = finest.points.size();
        split(finest, on_line);
        const std::vector<Vector3> middles(finest.points.begin() + static_cast<std::ptrdiff_t>(first),
                                           finest.points.end());
        fit(finest, middles, ground, on_line);
        std::vector<Vector3>& moves = made.displacements.emplace_back();
        for (std::size_t i = 0; i < middles.size(); ++i)
            moves.push_back(finest.points[first + i] - middles[i]);
        made.counts.push_back(static_cast<int>(finest.points.size()));
    }
    trace(finest, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
