// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/local_global/arap/multilevel_start.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <vector>

namespace sinew {

/// The rotations from which other methods than ARAP itself start: those of smooth as-rigid-as-possible
/// deformation on a graph with an eighth of the vertices, handed down to the vertices. They depend on the
/// poses alone and cost as much as 2 to 4 iterations of ARAP on the mesh. No system on the mesh itself is
/// factorised, unless it is too small for clusters.
///
///   call         repeat it when ...          cost
///   constructor  another set of handles      the graphs of the cascade, with two factorisations each
///   rotations()  the handles moved           some iterations on each graph; safe from several threads at
///                                            once, each with its own workspace
class CoarseStart
{
public:
    CoarseStart() = default;
    /// \param mesh       its lengths and their squares fit into single precision; see normal_unit().
    /// \param smoothing  > 0, alpha A, the square of a length: how far rotations even out. A shell of
    ///                   thickness t bends as ARAP does with t^2 / 2.
    /// \param rigidity   (n) how stiff the cells of the vertices are; empty where all are 1.
    /// \throw FactorizationFailed, Cancelled
    CoarseStart(const SurfaceMesh& mesh, const Regions& regions, double smoothing,
                std::vector<double> rigidity = {}, const Progress& progress = {});
    /// The same for the nodes of any graph, such as the faces of a mesh; `smoothing` is that of the cells.
    /// \param rest  (nodes, 3)
    CoarseStart(const HandleGraph& nodes, const GraphCells& cells, const Points& rest,
                const Progress& progress = {});

    /// Kept from one solve to the next, it is not allocated again.
    struct Workspace
    {
        GraphWorkspace top;
        std::vector<GraphWorkspace> levels;
    };

    /// \param targets        in the units of the mesh; of the nodes, where the graph is not that of a mesh.
    /// \param[out] vertices  (n) the rotation of each vertex or node; the identity in parts without a handle,
    ///                       and everywhere if no vertex is free.
    void rotations(const Targets& targets, Workspace& work, std::vector<Eigen::Quaterniond>& vertices) const;

    std::int64_t factor_bytes() const;

private:
    void build(const HandleGraph& nodes, const GraphCells& cells, const Points& rest,
               const Progress& progress);
    const ArapSystem& top() const { return level_ ? level_->graph : *mesh_; }

    int vertex_count_ = 0;
    /// The finest graph: clusters of the vertices, or the vertices themselves. Neither if no vertex is free.
    std::optional<RotationLevel> level_;
    std::optional<ArapSystem> mesh_;
    Points mesh_rest_; ///< of the nodes of mesh_
    MultilevelStart below_;
};

} // namespace sinew
