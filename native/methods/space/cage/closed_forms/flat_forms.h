// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"

#include <array>
#include <vector>

namespace sinew {

/// Coordinates in the plane of a flat cage, whose outline consists of any number of simple polygons.
///
/// A point is a place x in the plane and a height over it. Weights of the vertices say where x goes; Green
/// coordinates add weights of the outline's edges. The last column is the height, and moves the point along
/// the normal of the posed cage. So a rigid motion of the cage is reproduced, and points keep their distance
/// from the plane.
///
/// With r_k the distance of vertex k, alpha the angle of an edge seen from x, and for an edge from a to b of
/// length L, p the distance of its line, t_a < t_b its ends relative to the foot of x and J = ln(r_b / r_a):
///
///     mean value:  w_k = (tan(alpha_k-1 / 2) + tan(alpha_k / 2)) / r_k, divided by their sum
///     Green:       2 pi phi_a = (t_b alpha - p J) / L,    2 pi phi_b = (p J - t_a alpha) / L
///                  2 pi psi = L - p alpha - t_b ln r_b + t_a ln r_a
class FlatForms
{
public:
    /// \param cage  a flat one.
    FlatForms(const Cage& cage, const CageGeometry& geometry);

    int edge_count() const { return static_cast<int>(edges_.size()); }

    /// Weights of some points.
    /// \param[out] rows     (b, vertices + 1)
    /// \param[out] outside  (b)
    void mean_value(PointsView block, RowMatrix& rows, std::vector<char>& outside) const;
    /// \param[out] rows     (b, vertices + edges + 1); outside, the map is continued through the nearest
    /// edge.
    void green(PointsView block, RowMatrix& rows, std::vector<char>& outside) const;

    /// Where the columns behind the vertices are for a posed cage: for each edge its outer normal times its
    /// stretch (if `edges`), and the normal of the plane, times the size of the cage at rest.
    void controls(PointsView vertices, bool edges, Eigen::Ref<Points> controls) const;

private:
    using Vector2 = Eigen::Vector2d;
    struct Edge
    {
        int a, b;
        Vector2 along, outward;
        double length;
    };
    Vector2 flattened(const Vector3& x, double& height) const;
    double square_distance(const Edge& edge, const Vector2& x) const;
    int nearest(const Vector2& x) const;
    /// How often the outline winds around x.
    double winding(const Vector2& x) const;
    template <class Row>
    void add_green(const Vector2& x, Row&& row) const;
    /// Adds weights whose sum is `sum` and whose point is `vector`, by an edge.
    template <class Row>
    void represent(int edge, double sum, const Vector2& vector, Row&& row) const;

    const CageGeometry& geometry_;
    Vector3 x_, y_, normal_;
    double level_ = 0.0; ///< of the plane along the normal
    double size_;        ///< of the cage as it was given
    std::vector<Vector2> points_;
    std::vector<Edge> edges_;
};

} // namespace sinew
