// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/space/nonlinear/graph/near_nodes.h"
#include "native/methods/space/weights/blended_maps.h"

#include <array>
#include <vector>

namespace sinew {

/// The graph of an embedded deformation: nodes on a shape, the nodes that each point follows, and the pairs
/// of nodes that are to agree about where they are.
///
/// Two nodes agree if a vertex follows both, if one is among the four nearest to the other or as far as the
/// fourth, or if they are on different large parts of the shape and closer than 1.5 radii. What is not
/// connected then is joined by the three shortest pairs to what is next to it: first within each part of the
/// shape, then to the next part, if that is near, see are_near(), or without faces, as points of curves. What
/// is farther away is a piece of its own.
class DeformationGraph
{
public:
    DeformationGraph(const SurfaceMesh& mesh, int wanted, const Progress& progress);

    int size() const { return static_cast<int>(near_.nodes().size()); }
    /// (m, 3) the nodes.
    const Points& places() const { return places_; }
    /// Pairs a < b, ascending.
    const std::vector<std::array<int, 2>>& edges() const { return edges_; }
    /// (m) the piece of the graph that has each node: nodes of different pieces are not connected.
    const std::vector<int>& pieces() const { return pieces_; }
    /// The mean length of the edges; 1 without edges.
    double edge_length() const { return edge_length_; }

    /// The nodes that each of some points follows. A point at a vertex follows those of the vertex, one
    /// elsewhere those of the corners of the triangle closest to it. The same point gets the same shares in
    /// any company.
    std::vector<std::vector<BlendedMaps::Share>> shares(PointsView points) const;

private:
    void connect(const Progress& progress);
    struct Pieces;
    void join_parts();
    /// Joins the piece of the node `first` to the one next to it, in its part of the surface, or in any if
    /// that is near; whether it did.
    bool join_next(Pieces& pieces, int first, bool within_part);

    const SurfaceMesh& mesh_;
    NearNodes near_;
    Points places_;
    std::vector<std::array<int, 2>> edges_;
    std::vector<int> pieces_;
    double edge_length_ = 1.0;
};

} // namespace sinew
