// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace sinew {

/// The ring of each vertex: the vertices that share an edge of a triangle with it. Those of vertex i are
/// neighbours()[offsets()[i]] up to the next offset, by rising number.
class Rings
{
public:
    explicit Rings(const SurfaceMesh& mesh);

    const std::vector<int>& offsets() const { return offsets_; }
    const std::vector<int>& neighbours() const { return neighbours_; }
    int size() const { return static_cast<int>(offsets_.size()) - 1; }
    int valence(int vertex) const { return offsets_[vertex + 1] - offsets_[vertex]; }

    /// The unit normal of a ring: of the polygon that it forms around its mean where it is closed; otherwise
    /// of the triangles at the vertex. Zero where these have none.
    Vector3 normal(const PointsView& points, int vertex) const;

    /// What a ring says about its vertex, which is their weighted mean plus a height along the normal.
    struct Weights
    {
        std::vector<double> shares; ///< one per directed edge; those of a ring sum up to 1
        std::vector<int> folded; ///< vertices of closed rings whose projection overlaps
    };
    /// The mean-value coordinates of each vertex in its ring, both projected along the normal. Equal weights
    /// where the ring is open or has edges of three faces, and where a weight would not be positive: there
    /// the projection overlaps.
    Weights mean_value_weights(const PointsView& points) const;

    /// The rotation of a ring from one shape to another: it takes the normal along, and around the normal it
    /// is the one that fits the projected edges best.
    Eigen::Quaterniond turn(const PointsView& from, const PointsView& to, int vertex) const;

private:
    bool project(const PointsView& points, int vertex, std::vector<Vector3>& projected) const;

    std::vector<int> offsets_{0}, neighbours_;
    std::vector<int> first_corner_; ///< the corners of vertex i are [first_corner_[i], first_corner_[i + 1])
    /// Edges of the ring, as two numbers of directed edges, in the direction of the triangle.
    std::vector<std::array<int, 2>> corners_;
    std::vector<char> closed_;
};

} // namespace sinew
