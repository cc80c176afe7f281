// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/semi_regular.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/remeshing/decimation.h"
#include "native/mesh/trees/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sinew {

namespace {

constexpr double most_triangles = 2e7;

/// What new vertices are put onto.
class Ground
{
public:
    explicit Ground(const Manifold& cut) : tree_(cut.points, cut.triangles)
    {
        for (const Manifold::Line& line : cut.lines)
            lines_.push_back({cut.points[line.edge[0]], cut.points[line.edge[1]]});
    }

    /// Puts points from `first` on onto the lines, or else onto the surface.
    void project(std::vector<Vector3>& points, std::size_t first, const std::vector<char>& on_line) const
    {
        const std::vector<Vector3> asked(points.begin() + static_cast<std::ptrdiff_t>(first), points.end());
        const std::vector<int> closest = closest_lines(lines_, asked);
        parallel_for(
            static_cast<int>(asked.size()),
            [&](int i) {
                points[first + i] = on_line[first + i] && closest[i] >= 0
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

} // namespace

SemiRegular semi_regular(const SurfaceMesh& mesh, const SemiRegularOptions& options,
                         const std::vector<Edge>& given, const Progress& progress)
{
    if (options.levels < 1 || options.levels > 10)
        throw InvalidOption("levels must be 1 to 10");
    if (options.base_faces != 0 && options.base_faces < 4)
        throw InvalidOption("base_faces must be at least 4");
    progress.tick(0.0, "decimating");
    const Manifold cut(mesh, given, options.angle);
    const double share = std::pow(4.0, -options.levels);
    const int wanted = options.base_faces > 0
                           ? options.base_faces
                           : std::max(4, static_cast<int>(share * static_cast<double>(cut.triangles.size())));
    SemiRegular made;
    made.finest = decimated(cut, wanted, progress);
    Remeshed& finest = made.finest;
    if (static_cast<double>(finest.triangles.size()) / share > most_triangles)
        throw InvalidOption("levels: the last one would have more than 20 million triangles");
    join_cuts(finest, mesh, cut);
    const Ground ground(cut);
    std::vector<char> on_line(finest.points.size(), 0);
    for (const Edge& edge : finest.lines)
        for (int v : edge)
            on_line[v] = 1;
    ground.project(finest.points, 0, on_line);
    made.base = finest.triangles;
    made.counts.push_back(static_cast<int>(finest.points.size()));
    for (int level = 0; level < options.levels; ++level) {
        progress.tick(0.8, "fitting");
        const std::size_t first = finest.points.size();
        split(finest, on_line);
        const std::vector<Vector3> middles(finest.points.begin() + static_cast<std::ptrdiff_t>(first),
                                           finest.points.end());
        ground.project(finest.points, first, on_line);
        std::vector<Vector3>& moves = made.displacements.emplace_back();
        for (std::size_t i = 0; i < middles.size(); ++i)
            moves.push_back(finest.points[first + i] - middles[i]);
        made.counts.push_back(static_cast<int>(finest.points.size()));
    }
    trace(finest, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
