// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/operators/laplacian.h"

#include <functional>
#include <vector>

namespace sinew {

/// The right-hand side of the Poisson equation for a surface whose gradients are transformed triangle by
/// triangle.
///
/// Y. Yu et al. "Mesh Editing with Poisson-Based Gradient Field Manipulation." SIGGRAPH 2004. Tutorial,
/// section 4.5.1, Eq. 15: G^T D G x' = G^T D G'. A map T of a triangle turns its gradient by the transpose,
/// G' = G T^T.
///
/// The points y of a triangle and T y are linear on it. So its share of G^T D G' at corner i is the sum of
/// w_ij T (y_i - y_j) over its two edges there, with its half cotangents w. No gradient is computed, and the
/// matrix that belongs to it is laplacian_matrix() with `cotan` and the same metric, exactly, also where a
/// triangle has no area.
///
///   call         cost
///   constructor  O(n)
///   source()     O(n), one call of `change` per triangle
class TurnedGradients
{
public:
    TurnedGradients() = default;
    TurnedGradients(const SurfaceMesh& mesh, const TriangleMetric& metric);

    int triangle_count() const { return static_cast<int>(triangles_.size()); }

    /// Replaces two edges e of a triangle by T e - e. Called from several threads.
    using Change = std::function<void(int triangle, Vector3& first, Vector3& second)>;

    /// \param y       (n, 3) the points that are turned.
    /// \param forces  a workspace that is kept from call to call.
    /// \param[out] b  (n, 3) G^T D (G' - G), for the displacements from y.
    /// \return        the sum over the triangles of area |G' - G|^2.
    double source(const PointsView& y, const Change& change, std::vector<Vector3>& forces,
                  RowMatrix& b) const;

private:
    std::vector<Triangle> triangles_;
    std::vector<std::array<double, 3>> half_cotan_;
    std::vector<int> offsets_, corners_; ///< of each vertex: 3 t + k for corner k of triangle t
};

} // namespace sinew
