// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/volume/volume_graph.h"

#include "native/attachments/host_surface.h"
#include "native/core/dense.h"
#include "native/core/parallel.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/mesh/trees/winding_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <queue>
#include <unordered_map>
#include <utility>

namespace sinew {

namespace {

constexpr double cells_per_edge = 2.0; ///< the least width of a cell, in mean edges
constexpr double vertices_per_cell = 8.0;
constexpr double nearest = 0.5; ///< another piece to a point of the shell, in mean edges
constexpr double inside = 0.5;  ///< winding number
constexpr int least_triangles = 4; ///< that enclose anything
constexpr int most_cells = 1 << 20; ///< of a lattice along an axis
constexpr std::size_t hub = 64; ///< more neighbours than vertices of a mesh have, but for tips of large fans

/// For each vertex the centre of its cell, at most two edges away: the one next to it, else that of its first
/// neighbour that has one next to it. Centres are three edges apart or more, and few: each next one is that
/// around which the most vertices have none yet.
/// \param order  (n) all vertices; of equally good ones, the first is taken.
std::vector<int> cells_of_vertices(const std::vector<int>& order,
                                   const std::vector<std::array<int, 2>>& edges)
{
    const auto n = static_cast<int>(order.size());
    std::vector<int> ranks(n);
    for (int k = 0; k < n; ++k)
        ranks[order[k]] = k;
    std::vector<std::vector<int>> around(n);
    for (const auto& [a, b] : edges) {
        around[a].push_back(b);
        around[b].push_back(a);
    }
    std::vector<int> walks(n, 0);
    // Visits what is within two edges of v, but for ways through hubs, which would cost the square of a fan.
    int walk = 0;
    const auto visit_near = [&](int v, auto&& visit) {
        ++walk;
        const auto reach = [&](int u) {
            if (std::exchange(walks[u], walk) != walk)
                visit(u);
        };
        reach(v);
        for (const int u : around[v]) {
            reach(u);
            if (around[u].size() <= hub)
                std::ranges::for_each(around[u], reach);
        }
    };
    std::vector<int> gains(n, 0), nearby(n, -1), centre(n);
    std::priority_queue<std::pair<int, int>> best; // gain and minus the rank, as of when they were put in
    for (int v = 0; v < n; ++v) {
        visit_near(v, [&](int) { ++gains[v]; });
        best.emplace(gains[v], -ranks[v]);
    }
    std::vector<char> has_centre(n, 0);
    while (!best.empty()) {
        const auto [gain, minus] = best.top();
        const int v = order[-minus];
        best.pop();
        if (has_centre[v])
            continue;
        if (gain > gains[v]) { // a centre chosen since then is near
            best.emplace(gains[v], minus);
            continue;
        }
        const auto give = [&](int u) {
            if (!std::exchange(has_centre[u], 1))
                visit_near(u, [&](int w) { --gains[w]; });
        };
        nearby[v] = v;
        give(v);
        for (const int u : around[v]) {
            nearby[u] = v;
            give(u);
            std::ranges::for_each(around[u], give);
        }
    }
    for (int v = 0; v < n; ++v) {
        std::ranges::sort(around[v], {}, [&](int u) { return ranks[u]; });
        centre[v] = nearby[v] >= 0
                        ? nearby[v]
                        : nearby[*std::ranges::find_if(around[v], [&](int u) { return nearby[u] >= 0; })];
    }
    return centre;
}

/// A part of the surface, and what is inside of it.
class Body
{
public:
    Body(const Part& part, double edge)
        : part_(part), edge_(edge), host_(part), winding_(part.points, part.triangles)
    {
        host_.prepare_tree();
        // About the centroid, so that far from the origin nothing is lost.
        Vector3 weighted = Vector3::Zero();
        const auto middle = [&](const Triangle& t) -> Vector3 {
            return (part.points[t[0]] + part.points[t[1]] + part.points[t[2]]) / 3 - part.points[0];
        };
        for (std::size_t t = 0; t < part.triangles.size(); ++t)
            weighted += part.areas[t] * middle(part.triangles[t]);
        centre_ = part.points[0] + weighted / part.area;
        Matrix3 spread = Matrix3::Zero();
        double six = 0.0;
        for (std::size_t t = 0; t < part.triangles.size(); ++t) {
            const Corners p = corners_of(part.points, part.triangles[t]);
            six += (p[0] - centre_).cross(p[1] - centre_).dot(p[2] - centre_);
            const Vector3 at = (middle(part.triangles[t]) + part.points[0] - centre_) / part.extent();
            spread += part.areas[t] / part.area * at * at.transpose();
        }
        sign_ = six < 0 ? -1.0 : 1.0;
        volume_ = std::abs(six) / 6;
        axes_ = eigenvectors(spread).vectors;
    }

    double edge() const { return edge_; }
    double sign() const { return sign_; }
    const HostSurface& host() const { return host_; }
    TriangleTree::Place beneath(const Vector3& p) const { return host_.tree().closest_place(p); }
    /// Whether a point is inside, and farther from the surface than this.
    bool holds(const Vector3& p, double clearance) const
    {
        return (beneath(p).point - p).norm() > clearance && sign_ * winding_.at(p) > inside;
    }

    using Cell = std::array<int, 3>;
    struct Lattice
    {
        double width;
        std::vector<Cell> cells;
    };
    Vector3 position(const Cell& c, double width) const
    {
        return centre_ + axes_ * (width * Vector3(c[0], c[1], c[2]));
    }
    /// The lattice as it is found from places inside.
    Lattice lattice(const std::vector<Vector3>& seeds, const Progress& progress) const;

    static std::uint64_t key(const Cell& c)
    {
        std::uint64_t key = 0;
        for (int x : c)
            key = key << 21 | static_cast<std::uint64_t>(x + most_cells);
        return key;
    }

private:
    /// Nothing where there are more cells than `most`.
    std::optional<std::vector<Cell>> flood(const std::vector<Vector3>& seeds, double width,
                                           std::size_t most) const;

    const Part& part_;
    double edge_;
    HostSurface host_;
    WindingTree winding_;
    Vector3 centre_;
    Matrix3 axes_;
    double sign_ = 1.0, volume_ = 0.0;
};

Body::Lattice Body::lattice(const std::vector<Vector3>& seeds, const Progress& progress) const
{
    const double wanted = static_cast<double>(part_.points.size()) / vertices_per_cell;
    double width = std::max({cells_per_edge * edge_, std::cbrt(volume_ / std::max(wanted, 1.0)),
                             2 * part_.extent() / most_cells});
    for (;; width *= 1.25) { // what an open part encloses is more than a volume tells
        progress.tick(0.1, "filling the volume");
        if (auto cells = flood(seeds, width, static_cast<std::size_t>(1.25 * wanted) + 8))
            return {width, std::move(*cells)};
    }
}

std::optional<std::vector<Body::Cell>> Body::flood(const std::vector<Vector3>& seeds, double width,
                                                   std::size_t most) const
{
    std::vector<Cell> found, next;
    for (const Vector3& seed : seeds) {
        const Vector3 at = axes_.transpose() * (seed - centre_) / width;
        for (int corner = 0; corner < 8; ++corner) {
            Cell cell;
            for (int axis = 0; axis < 3; ++axis)
                cell[axis] = static_cast<int>(std::floor(at[axis])) + (corner >> axis & 1);
            next.push_back(cell);
        }
    }
    std::unordered_map<std::uint64_t, bool> seen;
    while (!next.empty()) {
        std::ranges::sort(next);
        next.erase(std::ranges::unique(next).begin(), next.end());
        std::erase_if(next, [&](const Cell& cell) { return !seen.emplace(key(cell), true).second; });
        std::vector<char> holds_cell(next.size());
        parallel_for(
            static_cast<int>(next.size()),
            [&](int i) { holds_cell[i] = holds(position(next[i], width), edge_ + width / 2); }, 64);
        std::vector<Cell> around;
        for (std::size_t i = 0; i < next.size(); ++i) {
            if (!holds_cell[i])
                continue;
            found.push_back(next[i]);
            for (int side = 0; side < 6; ++side) {
                Cell other = next[i];
                other[side / 2] += side % 2 ? 1 : -1;
                around.push_back(other);
            }
        }
        if (found.size() > most)
            return std::nullopt;
        next = std::move(around);
    }
    std::ranges::sort(found);
    return found;
}

/// What is inside one part.
struct Filling
{
    std::vector<int> centres; ///< vertices of the mesh that have a point of the shell
    std::vector<Vector3> shell, lattice;
    std::vector<std::array<int, 2>> edges; ///< of the lattice
    std::vector<std::array<int, 2>> links; ///< from the lattice to centres of the mesh
    std::vector<Triangle> carriers; ///< of the shell, and of the lattice, among the vertices of the mesh
};

/// Sums of the area normals around the vertices of a part.
std::vector<Vector3> normals_of(const Part& part)
{
    std::vector<Vector3> normals(part.points.size(), Vector3::Zero());
    for (const Triangle& t : part.triangles) {
        const Corners p = corners_of(part.points, t);
        for (int v : t)
            normals[v] += (p[1] - p[0]).cross(p[2] - p[0]);
    }
    return normals;
}

/// Lays the shell beneath the centres of a part.
/// \return places farther inside, from which the lattice can be found.
std::vector<Vector3> lay_shell(const Part& part, const Body& body, const std::vector<int>& centre,
                               Filling& in)
{
    const std::vector<Vector3> normals = normals_of(part);
    std::vector<int> local; // vertices of the part that are centres
    for (int v = 0; v < static_cast<int>(part.points.size()); ++v)
        if (centre[part.vertices[v]] == part.vertices[v] && normals[v].squaredNorm() > 0)
            local.push_back(v);
    const auto below = [&](int v, double depth) -> Vector3 {
        return part.points[v] - body.sign() * depth * normals[v].normalized();
    };
    const double edge = body.edge();
    std::vector<char> kept(local.size());
    parallel_for(
        static_cast<int>(local.size()),
        [&](int i) { kept[i] = body.holds(below(local[i], edge), nearest * edge); }, 64);
    std::vector<Vector3> seeds;
    for (std::size_t i = 0; i < local.size(); ++i)
        if (kept[i]) {
            in.centres.push_back(part.vertices[local[i]]);
            in.shell.push_back(below(local[i], edge));
            seeds.push_back(below(local[i], 3 * edge));
        }
    return seeds;
}

/// Fills the rest with the lattice, and joins it to itself and to the centres beside it.
void lay_lattice(const Part& part, const Body& body, const std::vector<int>& centre,
                 const std::vector<Vector3>& seeds, Filling& in, const Progress& progress)
{
    const Body::Lattice lattice = body.lattice(seeds, progress);
    std::unordered_map<std::uint64_t, int> number;
    for (const Body::Cell& cell : lattice.cells) {
        number.emplace(Body::key(cell), static_cast<int>(in.lattice.size()));
        in.lattice.push_back(body.position(cell, lattice.width));
    }
    std::vector<std::array<int, 6>> joined(lattice.cells.size()); // -1 - centre, or a point of the lattice
    parallel_for(
        static_cast<int>(in.lattice.size()),
        [&](int i) {
            for (int side = 0; side < 6; ++side) {
                Body::Cell other = lattice.cells[i];
                other[side / 2] += side % 2 ? 1 : -1;
                if (const auto it = number.find(Body::key(other)); it != number.end()) {
                    joined[i][side] = it->second;
                    continue;
                }
                const TriangleTree::Place place = body.beneath(body.position(other, lattice.width));
                const auto at =
                    std::ranges::min_element(body.host().triangles()[place.triangle], {}, [&](int v) {
                        return (part.points[v] - place.point).squaredNorm();
                    });
                joined[i][side] = -1 - centre[part.vertices[*at]];
            }
        },
        64);
    for (int i = 0; i < static_cast<int>(joined.size()); ++i)
        for (int other : joined[i])
            if (other < 0)
                in.links.push_back({i, -1 - other});
            else if (other > i)
                in.edges.push_back({i, other});
}

/// What is inside a part; nothing if it encloses nothing.
/// \param centre  of the cell of each vertex of the mesh.
Filling filling_of(const Part& part, double edge, const std::vector<int>& centre, const Progress& progress)
{
    Filling in;
    if (static_cast<int>(part.triangles.size()) < least_triangles || !(part.area > 1e-10 * edge * edge))
        return in;
    const Body body(part, edge);
    lay_lattice(part, body, centre, lay_shell(part, body, centre, in), in, progress);
    in.carriers.resize(in.shell.size() + in.lattice.size());
    parallel_for(
        static_cast<int>(in.carriers.size()),
        [&](int i) {
            const auto k = static_cast<std::size_t>(i);
            const Vector3& p = k < in.shell.size() ? in.shell[k] : in.lattice[k - in.shell.size()];
            const Triangle own = carriers_of(body.host(), body.beneath(p), p);
            for (int c = 0; c < 3; ++c)
                in.carriers[k][c] = part.vertices[own[c]];
        },
        64);
    return in;
}

/// Numbers the points of all parts, and joins them to each other and to the surface.
void join(const SurfaceMesh& mesh, const std::vector<std::array<int, 2>>& edges,
          const std::vector<int>& centre, const std::vector<Filling>& fillings, VolumeGraph& graph)
{
    const int n = mesh.vertex_count();
    std::vector<int> shell_of(n, -1);
    int count = n;
    for (const Filling& in : fillings)
        for (int v : in.centres)
            shell_of[v] = count++;
    graph.shell_count = count - n;
    for (const Filling& in : fillings)
        count += static_cast<int>(in.lattice.size());
    graph.points.resize(count - n, 3);
    graph.parts.resize(count - n);
    graph.nearby.resize(count - n);
    int shell = n, cell = n + graph.shell_count;
    for (std::size_t k = 0; k < fillings.size(); ++k) {
        const Filling& in = fillings[k];
        const int first = cell;
        const auto add = [&](int node, const Vector3& point, const Triangle& carriers) {
            graph.points.row(node - n) = point.transpose();
            graph.parts[node - n] = static_cast<int>(k);
            graph.nearby[node - n] = carriers[0];
            graph.attachments.add(node, carriers);
        };
        for (std::size_t i = 0; i < in.shell.size(); ++i)
            add(shell++, in.shell[i], in.carriers[i]);
        for (std::size_t i = 0; i < in.lattice.size(); ++i)
            add(cell++, in.lattice[i], in.carriers[in.shell.size() + i]);
        for (const auto& [a, b] : in.edges)
            graph.edges.push_back({first + a, first + b});
        for (const auto& [a, v] : in.links)
            graph.edges.push_back({shell_of[v] >= 0 ? shell_of[v] : v, first + a});
    }
    for (int v = 0; v < n; ++v)
        if (shell_of[centre[v]] >= 0)
            graph.edges.push_back({v, shell_of[centre[v]]});
    for (const auto& [a, b] : edges) {
        if (shell_of[centre[b]] >= 0)
            graph.edges.push_back({a, shell_of[centre[b]]});
        if (shell_of[centre[a]] >= 0)
            graph.edges.push_back({b, shell_of[centre[a]]});
    }
    for (const auto& [a, b] : edges)
        if (const auto [s, t] = std::minmax(shell_of[centre[a]], shell_of[centre[b]]); s >= 0 && s != t)
            graph.edges.push_back({s, t});
    std::ranges::sort(graph.edges);
    graph.edges.erase(std::ranges::unique(graph.edges).begin(), graph.edges.end());
    Points all(count, 3);
    all << mesh.points(), graph.points;
    graph.attachments.measure(view(all));
}

} // namespace

VolumeGraph volume_graph(const SurfaceMesh& mesh, const Components& components, const Progress& progress)
{
    const int n = mesh.vertex_count();
    const std::vector<std::array<int, 2>> edges = mesh.edges();
    const std::vector<int> centre = cells_of_vertices(order_by_place(mesh), edges);
    const std::vector<Part> parts = parts_of(mesh, components);
    VolumeGraph graph;
    graph.mean_edges.assign(parts.size(), 0.0);
    std::vector<double> edge_counts(parts.size(), 0.0);
    for (const auto& [a, b] : edges) {
        graph.mean_edges[components.labels[a]] += (mesh.point(a) - mesh.point(b)).norm();
        ++edge_counts[components.labels[a]];
    }
    std::vector<Filling> fillings;
    int done = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        graph.mean_edges[k] /= std::max(edge_counts[k], 1.0);
        progress.tick(0.1 * done / n, "filling the volume");
        done += static_cast<int>(parts[k].points.size());
        fillings.push_back(filling_of(parts[k], graph.mean_edges[k], centre, progress));
    }
    join(mesh, edges, centre, fillings, graph);
    return graph;
}

} // namespace sinew
