// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/space/weights/blended_maps.h"

#include <array>
#include <utility>
#include <vector>

namespace sinew {

class SurfaceFronts;

/// Nodes that are spread evenly over a shape, and for each of its vertices the few nodes near it.
///
/// A part that is large compared with the spacing of the nodes, and has faces, is measured along its surface:
/// its vertices follow its own nodes only, so that limbs side by side stay apart. All other vertices (small
/// parts, points of a cloud or of a curve) are measured straight, to nodes anywhere.
///
/// Each node is the vertex farthest from all nodes before it; of those that are equally far the one farthest
/// from the centre, and of those that a symmetry of the shape makes equal in this too the first. Where there
/// is a large part, no vertex outside of all faces is a node.
/// Distances along the surface are those of SurfaceFronts, which end where they have met `count` + 1 nearer
/// nodes; operators/geodesic_distance.h, whose fronts are straight, is off by some percent near single
/// points.
///
/// So nodes and weights depend on lengths alone. Rounding of the shape, as when its axes turn, changes
/// weights by about as much, and the nodes only where two vertices are equally far up to that, but do not
/// count as being so.
class NearNodes
{
public:
    /// Of a vertex: with d the distance, w = (1 - d / d_max)^2, and d_max that of the fifth node, or three
    /// times the radius where fewer are as near. Weights below 1e-4 are left out.
    static constexpr int count = 4;
    /// A node farther away than this many radii moves nothing.
    static constexpr float reach = 3.0F;

    /// \param wanted  how many nodes, >= 1; there are more if there are more large parts, and fewer if there
    ///                are fewer places.
    /// \param mesh    has to outlive this object.
    NearNodes(const SurfaceMesh& mesh, int wanted, const Progress& progress);

    /// The vertices at which the nodes are, ascending.
    const std::vector<int>& nodes() const { return nodes_; }
    /// Each node with the four nearest to it, and those as far as the fourth; a < b, in no order, some twice.
    const std::vector<std::array<int, 2>>& pairs() const { return pairs_; }
    /// How far a vertex is from its nearest node, at most.
    double radius() const { return radius_; }
    /// The nodes that a vertex follows, with weights that sum to 1.
    std::vector<BlendedMaps::Share> shares(int vertex) const;
    /// Those that a place anywhere follows, by straight distances.
    std::vector<BlendedMaps::Share> straight_shares(const Vector3& place) const;
    /// Whether a vertex is measured along its surface.
    bool is_on_surface(int vertex) const { return large_[parts_.labels[vertex]] != 0; }
    /// Whether a vertex is outside of all faces, while there is a large part: the nodes are those of the
    /// surface.
    bool is_loose(int vertex) const { return loose_[vertex] != 0; }
    int part(int vertex) const { return parts_.labels[vertex]; }

private:
    using Near = std::pair<float, int>; ///< the distance, and the node
    /// Of each vertex on a large part, its nearest node on that, and how far that is; else -1.
    struct Nearest
    {
        std::vector<float> distance;
        std::vector<int> node;
    };

    Nearest choose(const SurfaceFronts& fronts, int wanted, const Progress& progress);
    /// A bound of how far each node is from the fourth nearest other one.
    std::vector<float> to_fourth(const Nearest& nearest) const;
    void find_near(const SurfaceFronts& fronts, const Nearest& nearest, const Progress& progress);
    std::vector<BlendedMaps::Share> weighed(const Near* near, int found) const;

    const SurfaceMesh& mesh_;
    Components parts_;
    std::vector<char> large_; ///< of each part
    std::vector<char> loose_; ///< (n)
    std::vector<int> nodes_;
    std::vector<std::array<int, 2>> pairs_;
    double radius_ = 0.0;
    std::vector<Near> near_; ///< count + 1 per vertex, by rising distance; node -1 where there is none
};

} // namespace sinew
