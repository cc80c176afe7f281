// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/isotropic_remeshing.h"

#include "native/core/errors.h"
#include "native/mesh/remeshing/cgal_mesh.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace sinew {

namespace {

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

} // namespace

Remeshed remesh(const SurfaceMesh& mesh, const RemeshOptions& options, const std::vector<Edge>& given,
                const Progress& progress)
{
    require_at_least(options.length, 0.0, "length");
    if (options.rounds < 1)
        throw InvalidOption("rounds must be at least 1");
    if (!(options.angle > 0.0 && options.angle <= std::numbers::pi))
        throw InvalidOption("angle must be in (0, pi]");
    progress.tick(0.0, "remeshing");
    const Manifold cut(mesh, given, options.angle);
    const double area = area_of(cut.points, cut.triangles);
    if (!(area > 0.0))
        throw InvalidMesh("no face has an area");
    Remeshed made;
    made.length = options.length > 0.0 ? options.length : mean_edge_length(cut);
    const double triangles = area / (std::sqrt(3.0) / 4.0 * made.length * made.length);
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
    CGAL::Polygon_mesh_processing::isotropic_remeshing(work.faces(), made.length, work,
                                                       CGAL::parameters::number_of_iterations(options.rounds)
                                                           .edge_is_constrained_map(lines)
                                                           .vertex_is_constrained_map(stays_of(work)));
    read_back(work, made);
    join_cuts(made, mesh, cut);
    trace(made, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
