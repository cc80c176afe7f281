// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/loose_vertices.h"
#include "native/core/progress.h"
#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// Points inside a surface, and the graph that joins them to each other and to the n vertices. Each part has
/// points of its own. With h the mean edge of a part, they are
///
///   a shell   x_v - h n_v beneath some vertices, the centres, where that is inside, and no other piece of
///             the part is nearer than h / 2. No two centres are within two edges of each other, and each
///             vertex is in the cell of a centre that is.
///   a lattice of cubes along the principal axes of the part, farther inside than h and half a cell. A cell
///             is 2 h wide, or more where there would be more points than one per eight vertices.
///
/// Inside is where the winding number is above 1/2 (mesh/trees/winding_tree.h), so borders and holes are no
/// special cases. A part whose faces look inward counts as turned inside out; open sheets have no inside.
///
/// Edges join each point of the shell to the vertices of its cell and their neighbours, so that most vertices
/// hang on several points around them, and to the points beneath adjacent cells; points of the lattice to
/// their up to six neighbours, and in place of each missing one to the shell next to where it would be. So
/// every point is joined to the surface.
struct VolumeGraph
{
    Points points;                       ///< (g, 3) graph point k is node n + k
    std::vector<int> parts;              ///< (g) the part of each
    std::vector<int> nearby;             ///< (g) a vertex near each
    std::vector<std::array<int, 2>> edges; ///< nodes a < b, ascending
    std::vector<double> mean_edges;        ///< h of each part of the mesh
    int shell_count = 0;                 ///< the first points; those of the lattice follow, part by part
    /// The nodes of the graph on the surface: where its points are in another shape.
    LooseVertices attachments;

    int count() const { return static_cast<int>(points.rows()); }
};

/// Cost: O(n log n); 30 us per vertex.
/// \throw Cancelled  by `progress`.
VolumeGraph volume_graph(const SurfaceMesh& mesh, const Components& components,
                         const Progress& progress = {});

} // namespace sinew
