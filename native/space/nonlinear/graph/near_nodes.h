// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"
#include "native/space/weights/blended_maps.h"

#include <utility>
#include <vector>

namespace sinew {

/// Nodes that are spread evenly over a shape, and for each of its vertices the few nodes near it.
///
/// A part that is large compared with the spacing of the nodes, and has faces, is measured along its surface:
/// its vertices follow its own nodes only, so that limbs side by side stay apart. All other vertices (small
/// parts, points of a cloud or of a curve) are measured straight, to nodes anywhere.
///
/// Each node is the vertex farthest from all nodes before it. Distances along the surface are those of fronts
/// that cross the triangles and end where they have met `count` + 1 nearer nodes. A front is taken as that of
/// a point in the plane of each triangle, which is exact where the surface unfolds into a plane (M. Novotni,
/// R. Klein, "Computing Geodesic Distances on Triangular Meshes", WSCG 2002); operators/geodesic_distance.h,
/// whose fronts are straight, is off by some percent near single points.
class NearNodes
{
public:
    /// Of a vertex: with d the distance, w = (1 - d / d_max)^2, and d_max that of the fifth node, or three
    /// times the radius where fewer are as near.
    static constexpr int count = 4;

    /// \param wanted  how many nodes, >= 1; there are more if there are more large parts, and fewer if there
    ///                are fewer places.
    /// \param mesh    has to outlive this object.
    NearNodes(const SurfaceMesh& mesh, int wanted, const Progress& progress);

    /// The vertices at which the nodes are.
    const std::vector<int>& nodes() const { return nodes_; }
    /// How far a vertex is from its nearest node, at most.
    double radius() const { return radius_; }
    /// The nodes that a vertex follows, with weights that sum to 1.
    std::vector<BlendedMaps::Share> shares(int vertex) const;
    /// Those that a place anywhere follows, by straight distances.
    std::vector<BlendedMaps::Share> straight_shares(const Vector3& place) const;
    /// Whether a vertex is measured along its surface.
    bool is_on_surface(int vertex) const { return large_[parts_.labels[vertex]] != 0; }
    int part(int vertex) const { return parts_.labels[vertex]; }

private:
    using Near = std::pair<double, int>; ///< the distance, and the node
    class Fronts;

    void choose(int wanted, const Progress& progress);
    void find_near(const Progress& progress);
    std::vector<BlendedMaps::Share> weighed(const Near* near, int found) const;

    const SurfaceMesh& mesh_;
    Components parts_;
    std::vector<char> large_; ///< of each part
    std::vector<int> nodes_;
    double radius_ = 0.0;
    std::vector<Near> near_; ///< count + 1 per vertex, by rising distance; node -1 where there is none
};

} // namespace sinew
