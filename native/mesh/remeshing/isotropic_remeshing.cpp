// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/isotropic_remeshing.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/remeshing/cgal_mesh.h"
#include "native/mesh/trees/triangle_tree.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace sinew {

namespace {

using Vertex = CgalMesh::Vertex_index;

constexpr double most_triangles = 2e7, most_splits = 1e8;

/// Which edges are lines. CGAL asks so often that this is where progress is reported.
struct Lines
{
    using key_type = CgalMesh::Edge_index;
    using value_type = bool;
    using reference = bool;
    using category = boost::read_write_property_map_tag;

    CgalMesh::Property_map<key_type, bool> on;
    const Progress* progress = nullptr;
    std::size_t* asked = nullptr;
    double expected = 1.0; ///< how often it will be asked, about

    friend bool get(const Lines& lines, key_type edge)
    {
        if (++*lines.asked % 4096 == 0)
            lines.progress->tick(0.8 * (1.0 - std::exp(-2.0 * *lines.asked / lines.expected)), "remeshing");
        return lines.on[edge];
    }
    friend void put(const Lines& lines, key_type edge, bool value) { lines.on[edge] = value; }
};

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

/// Whether no face around a vertex turns over when the vertex moves.
bool keeps_sides(const CgalMesh& mesh, Vertex v, const Vector3& from, const Vector3& to)
{
    for (const auto h : mesh.halfedges_around_target(mesh.halfedge(v))) {
        const Vector3 a = place_of(mesh, mesh.source(h)), b = place_of(mesh, mesh.target(mesh.next(h)));
        const Vector3 before = (from - a).cross(b - a), after = (to - a).cross(b - a);
        if (!(before.dot(after) > 0.0) && before != Vector3::Zero())
            return false;
    }
    return true;
}

/// Moves the vertices that lie on no line along the surface towards the mean of their neighbours.
void relax(CgalMesh& mesh, const TriangleTree& surface)
{
    const auto line = lines_of(mesh);
    const auto stays = stays_of(mesh);
    std::vector<Vertex> moving;
    for (const auto v : mesh.vertices()) {
        bool free = !stays[v] && !mesh.is_isolated(v);
        if (free)
            for (const auto h : mesh.halfedges_around_target(mesh.halfedge(v)))
                free = free && !line[mesh.edge(h)] && !mesh.is_border(mesh.edge(h));
        if (free)
            moving.push_back(v);
    }
    std::vector<Vector3> aims(moving.size());
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
            aims[i] = surface.closest(p + move);
        },
        512);
    for (std::size_t i = 0; i < moving.size(); ++i) {
        const Vector3 from = place_of(mesh, moving[i]);
        Vector3 to = aims[i];
        for (int halves = 1; halves <= 5 && !keeps_sides(mesh, moving[i], from, to); ++halves)
            to = surface.closest(from + std::ldexp(1.0, -halves) * (aims[i] - from));
        if (keeps_sides(mesh, moving[i], from, to))
            mesh.point(moving[i]) = {to.x(), to.y(), to.z()};
    }
}

} // namespace

Remeshed remesh(const SurfaceMesh& mesh, const RemeshOptions& options, const std::vector<Edge>& given,
                const Progress& progress)
{
    require_at_least(options.length, 0.0, "length");
    if (options.rounds < 1)
        throw InvalidOption("rounds must be at least 1");
    progress.tick(0.0, "remeshing");
    const Manifold cut(mesh, given, options.angle);
    Remeshed made;
    made.length = options.length > 0.0 ? options.length : mean_edge_length(cut);
    const double triangles = cut.area / (std::sqrt(3.0) / 4.0 * made.length * made.length);
    // Edges are split before the triangles get their shape, so that a needle becomes many.
    double splits = 0.0;
    for (const auto& [a, b, c] : cut.triangles) {
        const Vector3 &p = cut.points[a], &q = cut.points[b], &r = cut.points[c];
        const double longest =
            std::max({(p - q).squaredNorm(), (q - r).squaredNorm(), (r - p).squaredNorm()});
        splits += longest / (made.length * made.length);
    }
    if (splits > most_splits)
        throw InvalidOption("length: " + std::to_string(made.length) + " is too short for the longest edges");
    if (triangles > most_triangles)
        throw InvalidOption("length: " + std::to_string(made.length) + " would give about " +
                            std::to_string(static_cast<long>(triangles / 1e6)) + " million triangles");
    CgalMesh work = cgal_mesh(cut);
    std::size_t asked = 0;
    const Lines lines{lines_of(work), &progress, &asked,
                      0.8 * options.rounds * (triangles + static_cast<double>(cut.triangles.size()))};
    const TriangleTree surface(cut.points, cut.triangles);
    for (int round = 0; round < options.rounds; ++round) {
        CGAL::Polygon_mesh_processing::isotropic_remeshing(work.faces(), made.length, work,
                                                           CGAL::parameters::number_of_iterations(1)
                                                               .number_of_relaxation_steps(0)
                                                               .do_project(false)
                                                               .projection_functor(Stay{&work})
                                                               .edge_is_constrained_map(lines)
                                                               .vertex_is_constrained_map(stays_of(work)));
        relax(work, surface);
    }
    read_back(work, made);
    join_cuts(made, mesh, cut);
    trace(made, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
