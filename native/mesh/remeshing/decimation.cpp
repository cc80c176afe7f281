// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/decimation.h"

#include "native/core/errors.h"
#include "native/mesh/remeshing/cgal_mesh.h"

#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using Vertex = CgalMesh::Vertex_index;

/// The lines of a mesh while its edges collapse.
struct Lines
{
    std::vector<std::vector<Vertex>> beside; ///< of each vertex the next ones along its lines
    std::vector<char> stays;

    bool on_line(Vertex v) const { return stays[v] || !beside[v].empty(); }
    bool are_beside(Vertex a, Vertex b) const { return std::ranges::find(beside[a], b) != beside[a].end(); }
    bool share_neighbour(Vertex a, Vertex b) const
    {
        return std::ranges::any_of(beside[a], [&](Vertex v) { return are_beside(b, v); });
    }
    /// One vertex takes the place of another one.
    void join(Vertex kept, Vertex gone)
    {
        stays[kept] = stays[kept] || stays[gone];
        for (Vertex other : std::exchange(beside[gone], {})) {
            std::erase(beside[other], gone);
            if (other != kept && !are_beside(kept, other)) {
                beside[kept].push_back(other);
                beside[other].push_back(kept);
            }
        }
    }
};

/// Where the vertex goes to which an edge collapses; nowhere where that would move a line.
struct Placement
{
    const Lines* lines;
    simplification::LindstromTurk_placement<CgalMesh> best;

    template <class Profile>
    auto operator()(const Profile& profile) const -> decltype(best(profile))
    {
        const Vertex a = profile.v0(), b = profile.v1();
        const bool along = lines->are_beside(a, b);
        if ((lines->stays[a] && lines->stays[b]) || (along && lines->share_neighbour(a, b)) ||
            (!along && lines->on_line(a) && lines->on_line(b)))
            return {};
        if (lines->stays[a] || (!along && lines->on_line(a)))
            return profile.p0();
        if (lines->stays[b] || (!along && lines->on_line(b)))
            return profile.p1();
        auto found = best(profile);
        if (!found || !along)
            return found;
        const auto ahead = profile.p1() - profile.p0();
        const double length = ahead.squared_length();
        const double share = length > 0.0 ? ((*found - profile.p0()) * ahead) / length : 0.0;
        return profile.p0() + std::clamp(share, 0.0, 1.0) * ahead;
    }
};

struct Stop
{
    std::size_t wanted;
    const Progress* progress;

    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile& profile, std::size_t initial, std::size_t current) const
    {
        const double edges = 1.5 * static_cast<double>(wanted), whole = static_cast<double>(initial) - edges;
        if (current % 1024 == 0 && whole > 0.0)
            progress->tick(std::clamp(0.8 * static_cast<double>(initial - current) / whole, 0.0, 0.8),
                           "decimating");
        return profile.surface_mesh().number_of_faces() <= wanted;
    }
};

struct Follow : simplification::Edge_collapse_visitor_base<CgalMesh>
{
    Lines* lines;

    explicit Follow(Lines* followed) : lines(followed) {}
    // NOLINTNEXTLINE(bugprone-derived-method-shadowing-base-method): so that CGAL calls it
    void OnCollapsed(const Profile& profile, const Vertex& kept)
    {
        lines->join(kept, kept == profile.v0() ? profile.v1() : profile.v0());
    }
};

} // namespace

Remeshed decimated(Manifold& cut, int faces, double angle, const Progress& progress)
{
    const double grows = std::sqrt(static_cast<double>(cut.triangles.size()) / faces);
    cut.keep_lines(angle, std::max(1.0, grows) * cut.mean_edge);
    CgalMesh work = cgal_mesh(cut);
    const auto is_line = lines_of(work);
    const auto stays = stays_of(work);
    Lines lines{std::vector<std::vector<Vertex>>(work.num_vertices()),
                std::vector<char>(work.num_vertices(), 0)};
    for (const auto v : work.vertices())
        lines.stays[v] = stays[v];
    for (const auto e : work.edges())
        if (is_line[e] || work.is_border(e)) {
            const auto h = work.halfedge(e);
            lines.beside[work.source(h)].push_back(work.target(h));
            lines.beside[work.target(h)].push_back(work.source(h));
        }
    const Placement placement{&lines, {}};
    simplification::edge_collapse(
        work, Stop{static_cast<std::size_t>(faces), &progress},
        CGAL::parameters::get_cost(simplification::LindstromTurk_cost<CgalMesh>())
            .get_placement(simplification::Bounded_normal_change_placement<Placement>(placement))
            .visitor(Follow(&lines)));
    for (const auto e : work.edges()) {
        const auto h = work.halfedge(e);
        is_line[e] = lines.are_beside(work.source(h), work.target(h));
    }
    Remeshed made;
    read_back(work, made);
    return made;
}

Remeshed decimate(const SurfaceMesh& mesh, const DecimateOptions& options, const std::vector<Edge>& given,
                  const Progress& progress)
{
    if (options.faces < 4)
        throw InvalidOption("faces must be at least 4");
    progress.tick(0.0, "decimating");
    Manifold cut(mesh, given);
    Remeshed made = decimated(cut, options.faces, options.angle, progress);
    join_cuts(made, mesh, cut);
    trace(made, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
