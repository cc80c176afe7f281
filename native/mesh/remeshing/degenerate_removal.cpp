// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/remeshing/degenerate_removal.h"

#include "native/core/errors.h"
#include "native/mesh/remeshing/cgal_mesh.h"

#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/version.h>

#include <cmath>

namespace sinew {

Remeshed remove_degenerate(const SurfaceMesh& mesh, const DegenerateOptions& options,
                           const std::vector<Edge>& given, const Progress& progress)
{
    if (!(options.ratio > 1.0) || !std::isfinite(options.ratio))
        throw InvalidOption("ratio must be more than 1");
    if (!(options.cap > std::numbers::pi / 2 && options.cap <= std::numbers::pi))
        throw InvalidOption("cap must be in (pi / 2, pi]");
    if (!(options.share > 0.0) || !std::isfinite(options.share))
        throw InvalidOption("share must be more than 0");
    progress.tick(0.0, "removing needles");
    Manifold cut(mesh, given);
    const double shortest = options.share * cut.mean_edge;
    cut.keep_lines(options.angle, cut.mean_edge);
    CgalMesh work = cgal_mesh(cut);
    namespace processing = CGAL::Polygon_mesh_processing;
#if CGAL_VERSION_MAJOR < 6
    processing::experimental::remove_almost_degenerate_faces(
        work.faces(), work, std::cos(options.cap), options.ratio, shortest,
        CGAL::parameters::edge_is_constrained_map(lines_of(work)).vertex_is_constrained_map(stays_of(work)));
#else
    processing::remove_almost_degenerate_faces(work.faces(), work,
                                               CGAL::parameters::cap_threshold(std::cos(options.cap))
                                                   .needle_threshold(options.ratio)
                                                   .collapse_length_threshold(shortest)
                                                   .edge_is_constrained_map(lines_of(work))
                                                   .vertex_is_constrained_map(stays_of(work)));
#endif
    Remeshed made;
    read_back(work, made);
    if (made.triangles.empty())
        throw InvalidMesh("no face has an area");
    join_cuts(made, mesh, cut);
    trace(made, mesh, cut, given, progress);
    return made;
}

} // namespace sinew
