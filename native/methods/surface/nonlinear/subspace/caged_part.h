// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/caging/fineness.h"
#include "native/core/dense.h"
#include "native/core/progress.h"
#include "native/local_global/graph/clusters.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/local_global/reduced/subspace_cells.h"
#include "native/mesh/frames/enclosed_volume.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/space/cage/mean_value.h"

#include <memory>
#include <optional>
#include <vector>

namespace sinew {

/// A connected part of a mesh in its cage, whose vertices are the unknowns.
struct CagedPart
{
    /// \param members     its vertices, rising.
    /// \param edges       between them.
    /// \param given       its cage; without one, it gets its own, or is its own subspace if it has no more
    ///                    vertices than such a cage.
    /// \param cage_faces  triangles of its own cage; 0 for 160, and more beside details, as far as these need
    /// them.
    /// \param details     around what handles hold.
    CagedPart(const SurfaceMesh& mesh, const std::vector<int>& members, const GraphEdges& edges,
              const std::optional<SurfaceMesh>& given, int cage_faces, const std::vector<Detail>& details,
              const Progress& progress);

    std::vector<int> vertices;
    std::vector<Triangle> triangles; ///< of these
    Points rest;                     ///< (n, 3)
    double size = 0.0;
    std::optional<SurfaceMesh> cage; ///< none where the part is its own subspace
    Points y;                        ///< (c, 3) the unknowns at rest
    std::unique_ptr<MeanValue> coordinates; ///< null where the part is its own subspace
    PointWeights own_weights;               ///< in that case
    RowMatrix coarse;                ///< (m, c) the means of the weights of groups of vertices
    std::vector<int> groups;         ///< (n) the coarse point of each vertex
    Points coarse_rest;              ///< (m, 3)
    CholeskyFactor projection;       ///< of coarse^T coarse
    EnclosedVolume volume;
    CoarseVolume coarse_volume;
    double rest_volume = 0.0;
    bool has_volume = false;

    /// (n, c)
    const PointWeights& weights() const { return coordinates ? coordinates->weights() : own_weights; }
    /// The same with rows that sum to 1 exactly.
    RowMatrix exact_weights() const;
    /// (m, 3) the means of points (n, 3) of each group.
    Points means(const Points& points) const;
};

/// Clusters of a part. Vertices of different `hard` numbers are in different clusters.
Clusters clusters_of(const GraphEdges& edges, const Points& rest, std::vector<int> hard, int wanted);

} // namespace sinew
