// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/isotropic_remeshing.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/mesh/remeshing/cgal_mesh.h"
#include "native/mesh/trees/triangle_tree.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <string>
#include <utility>

namespace sinew {

namespace {

using Vertex = CgalMesh::Vertex_index;

CgalMesh::Property_map<Vertex, double> lengths_of(CgalMesh& mesh)
{
    return mesh.add_property_map<Vertex, double>("v:length", 0.0).first;
}

constexpr double most_triangles = 2e7, most_splits = 1e8;

/// CGAL would relax and project by itself, and crashes where all faces around a vertex have no area.
struct Stay
{
    const CgalMesh* mesh;

    CgalKernel::Point_3 operator()(Vertex v) const { return mesh->point(v); }
};

Vector3 place_of(const CgalMesh& mesh, Vertex v)
{
    const auto& p = mesh.point(v);
    return {p.x(), p.y(), p.z()};
}

/// Whether no face around a vertex turns over when it moves, but for those with another vertex.
bool keeps_sides(const CgalMesh& mesh, Vertex v, const Vector3& from, const Vector3& to,
                 Vertex other = CgalMesh::null_vertex())
{
    for (const auto h : mesh.halfedges_around_target(mesh.halfedge(v))) {
        const Vertex one = mesh.source(h), next = mesh.target(mesh.next(h));
        if (mesh.is_border(h) || one == other || next == other)
            continue;
        const Vector3 a = place_of(mesh, one), b = place_of(mesh, next);
        const Vector3 before = (from - a).cross(b - a), after = (to - a).cross(b - a);
        if (!(before.dot(after) > 0.0) && before != Vector3::Zero())
            return false;
    }
    return true;
}

/// Splits and collapses edges by what their length is in units of the length wanted at their ends.
class Lengths
{
public:
    Lengths(CgalMesh& mesh, const Progress& progress, double begin, double share)
        : mesh_(mesh), line_(lines_of(mesh)), cut_(cuts_of(mesh)), stays_(stays_of(mesh)),
          wanted_(lengths_of(mesh)), progress_(progress), begin_(begin), share_(share)
    {
    }

    /// Halves edges longer than 4/3, the longest first. Both sides of a cut are halved in the same places: new
    /// vertices there stay, so that they can be joined.
    void split_long()
    {
        Queue<std::less<>> waiting;
        const auto look = [&](Halfedge h) {
            if (const double length = squared(mesh_.source(h), mesh_.target(h)); length > longest)
                waiting.emplace(length, h);
        };
        for (const auto e : mesh_.edges())
            look(mesh_.halfedge(e));
        empty(waiting, 0.0, [&](Halfedge h) {
            const Vertex from = mesh_.source(h), to = mesh_.target(h);
            const Halfedge half = CGAL::Euler::split_edge(h, mesh_);
            const Vertex middle = mesh_.target(half);
            mesh_.point(middle) = CGAL::midpoint(mesh_.point(from), mesh_.point(to));
            wanted_[middle] = 0.5 * (wanted_[from] + wanted_[to]);
            line_[mesh_.edge(half)] = line_[mesh_.edge(h)];
            cut_[mesh_.edge(half)] = stays_[middle] = cut_[mesh_.edge(h)];
            for (const Halfedge before : {half, mesh_.opposite(h)})
                if (!mesh_.is_border(before)) {
                    const Halfedge across = mesh_.next(mesh_.next(before));
                    look(CGAL::Euler::split_face(before, across, mesh_));
                }
            look(h);
            look(half);
        });
    }

    /// Collapses edges shorter than 4/5, the shortest first, where no edge becomes longer than 4/3.
    void collapse_short()
    {
        Queue<std::greater<>> waiting;
        const auto look = [&](Halfedge h) {
            if (const double length = squared(mesh_.source(h), mesh_.target(h)); length < shortest)
                waiting.emplace(length, h);
        };
        for (const auto e : mesh_.edges())
            look(mesh_.halfedge(e));
        empty(waiting, 0.5, [&](Halfedge h) {
            if (!may_go(h))
                h = mesh_.opposite(h);
            if (!may_go(h) || !CGAL::Euler::does_satisfy_link_condition(mesh_.edge(h), mesh_))
                return;
            line_[mesh_.edge(h)] = false;
            const Vertex kept = CGAL::Euler::collapse_edge(mesh_.edge(h), mesh_, line_);
            for (const auto around : mesh_.halfedges_around_target(mesh_.halfedge(kept)))
                look(around);
        });
    }

private:
    using Halfedge = CgalMesh::Halfedge_index;
    template <class Order>
    using Queue =
        std::priority_queue<std::pair<double, Halfedge>, std::vector<std::pair<double, Halfedge>>, Order>;

    static constexpr double longest = 16.0 / 9.0, shortest = 16.0 / 25.0;

    double squared(Vertex a, Vertex b) const
    {
        const double wanted = std::min(wanted_[a], wanted_[b]);
        return CGAL::squared_distance(mesh_.point(a), mesh_.point(b)) / (wanted * wanted);
    }

    /// Handles the edges that still have the length that they had when they began to wait.
    template <class Order, class Handle>
    void empty(Queue<Order>& waiting, double done, const Handle& handle)
    {
        for (int count = 0; !waiting.empty();) {
            const auto [length, h] = waiting.top();
            waiting.pop();
            if (++count % 4096 == 0)
                progress_.tick(begin_ + share_ * (done + 0.4 * count / (count + waiting.size())),
                               "remeshing");
            if (!mesh_.is_removed(h) && squared(mesh_.source(h), mesh_.target(h)) == length)
                handle(h);
        }
    }

    bool on_line(Halfedge h) const { return line_[mesh_.edge(h)] || mesh_.is_border(mesh_.edge(h)); }

    /// Whether the vertex at the source may move to that at the target.
    bool may_go(Halfedge h) const
    {
        const Vertex from = mesh_.source(h), to = mesh_.target(h);
        if (stays_[from])
            return false;
        for (const auto around : mesh_.halfedges_around_target(mesh_.opposite(h)))
            if ((on_line(around) && !on_line(h)) || squared(mesh_.source(around), to) > longest)
                return false;
        return keeps_sides(mesh_, from, place_of(mesh_, from), place_of(mesh_, to), to);
    }

    CgalMesh& mesh_;
    CgalMesh::Property_map<CgalMesh::Edge_index, bool> line_, cut_;
    CgalMesh::Property_map<Vertex, bool> stays_;
    CgalMesh::Property_map<Vertex, double> wanted_;
    const Progress& progress_;
    double begin_, share_;
};

double length_at(const TriangleTree::Place& place, const Manifold& cut, const std::vector<double>& lengths)
{
    const Triangle& on = cut.triangles[place.triangle];
    return weights_in(corners_of(cut.points, on), place.point)
        .dot(Vector3(lengths[on[0]], lengths[on[1]], lengths[on[2]]));
}

/// Moves the vertices that lie on no line along the surface towards the mean of their neighbours.
/// \param lengths  (points of the surface) wanted there.
void relax(CgalMesh& mesh, const TriangleTree& surface, const Manifold& cut,
           const std::vector<double>& lengths)
{
    const auto line = lines_of(mesh);
    const auto stays = stays_of(mesh);
    const auto wanted = lengths_of(mesh);
    std::vector<Vertex> moving;
    for (const auto v : mesh.vertices()) {
        bool free = !stays[v] && !mesh.is_isolated(v);
        if (free)
            for (const auto h : mesh.halfedges_around_target(mesh.halfedge(v)))
                free = free && !line[mesh.edge(h)] && !mesh.is_border(mesh.edge(h));
        if (free)
            moving.push_back(v);
    }
    std::vector<TriangleTree::Place> aims(moving.size());
    parallel_for(
        static_cast<int>(moving.size()),
        [&](int i) {
            const Vector3 p = place_of(mesh, moving[i]);
            Vector3 move = Vector3::Zero(), normal = Vector3::Zero();
            int count = 0;
            for (const auto h : mesh.halfedges_around_target(mesh.halfedge(moving[i]))) {
                const Vector3 along = place_of(mesh, mesh.source(h)) - p;
                normal += (place_of(mesh, mesh.target(mesh.next(h))) - p).cross(along);
                move += along;
                ++count;
            }
            move /= count;
            if (const double length = normal.squaredNorm(); length > 0.0)
                move -= move.dot(normal) / length * normal;
            aims[i] = surface.closest_place(p + move);
        },
        512);
    for (std::size_t i = 0; i < moving.size(); ++i) {
        const Vector3 from = place_of(mesh, moving[i]);
        TriangleTree::Place to = aims[i];
        for (int halves = 1; halves <= 5 && !keeps_sides(mesh, moving[i], from, to.point); ++halves)
            to = surface.closest_place(from + std::ldexp(1.0, -halves) * (aims[i].point - from));
        if (!keeps_sides(mesh, moving[i], from, to.point))
            continue;
        mesh.point(moving[i]) = {to.point.x(), to.point.y(), to.point.z()};
        wanted[moving[i]] = length_at(to, cut, lengths);
    }
}

/// The length that is wanted at each point.
std::vector<double> wanted_lengths(const SurfaceMesh& mesh, const Manifold& cut,
                                   const std::vector<double>& given)
{
    for (std::size_t v = 0; v < given.size(); ++v)
        if (!(given[v] > 0.0 && std::isfinite(given[v])))
            throw InvalidOption("length " + std::to_string(v) + " must be more than 0");
    if (given.size() < 2)
        return std::vector<double>(cut.points.size(), given.empty() ? cut.mean_edge : given.front());
    if (static_cast<int>(given.size()) != mesh.vertex_count())
        throw InvalidOption("there are " + std::to_string(given.size()) + " lengths for " +
                            std::to_string(mesh.vertex_count()) + " vertices");
    std::vector<double> lengths;
    for (int v : cut.originals)
        lengths.push_back(given[v]);
    return lengths;
}

} // namespace

Remeshed remesh(const SurfaceMesh& mesh, const RemeshOptions& options, const std::vector<Edge>& given,
                const Progress& progress)
{
    if (options.rounds < 1)
        throw InvalidOption("rounds must be at least 1");
    progress.tick(0.0, "remeshing");
    Manifold cut(mesh, given);
    const std::vector<double> lengths = wanted_lengths(mesh, cut, options.lengths);
    cut.keep_lines(options.angle, std::ranges::min(lengths));
    Remeshed made;
    made.length = options.lengths.size() < 2 ? lengths.front() : 0.0;
    // Edges are split before the triangles get their shape, so that a needle becomes many.
    double triangles = 0.0, splits = 0.0;
    for (const Triangle& t : cut.triangles) {
        const auto [p, q, r] = corners_of(cut.points, t);
        const double length = std::min({lengths[t[0]], lengths[t[1]], lengths[t[2]]});
        const double longest =
            std::max({(p - q).squaredNorm(), (q - r).squaredNorm(), (r - p).squaredNorm()});
        triangles += 0.5 * (q - p).cross(r - p).norm() / (std::sqrt(3.0) / 4.0 * length * length);
        splits += longest / (length * length);
    }
    const std::string told = "length: " + shortest(std::ranges::min(lengths));
    if (splits > most_splits)
        throw InvalidOption(told + " is too short for the longest edges");
    if (triangles > most_triangles)
        throw InvalidOption(told + " would give about " + std::to_string(static_cast<long>(triangles / 1e6)) +
                            " million triangles");
    CgalMesh work = cgal_mesh(cut);
    const TriangleTree surface(cut.points, cut.triangles);
    const auto wanted = lengths_of(work);
    for (const auto v : work.vertices())
        wanted[v] = static_cast<std::size_t>(v) < lengths.size()
                        ? lengths[v]
                        : length_at(surface.closest_place(place_of(work, v)), cut, lengths);
    for (int round = 0; round < options.rounds; ++round) {
        const double share = 0.8 / options.rounds;
        Lengths edges(work, progress, round * share, share);
        edges.split_long();
        edges.collapse_short();
        CGAL::Polygon_mesh_processing::isotropic_remeshing(work.faces(), 1.0, work,
                                                           CGAL::parameters::number_of_iterations(1)
                                                               .do_split(false)
                                                               .do_collapse(false)
                                                               .number_of_relaxation_steps(0)
                                                               .do_project(false)
                                                               .projection_functor(Stay{&work})
                                                               .edge_is_constrained_map(lines_of(work))
                                                               .vertex_is_constrained_map(stays_of(work)));
        relax(work, surface, cut, lengths);
    }
    read_back(work, made);
    join_cuts(made, mesh, cut);
    trace(made, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
