// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <functional>
#include <span>
#include <vector>

namespace sinew {

// Conventions, stated here once for the whole library. The Laplacian matrix L is symmetric
// positive semi-definite, weak (not divided by area) and double:
//
//     (L f)_i = sum_j w_ij (f_i - f_j),    Delta f = -M^-1 L f,    M = diag(mass).
//
// L is minus the symmetric matrix of the tutorial's appendix; the factors are those of Eq. 7.

/// Discretisations of section 3.2.
///
///   name           w_ij                              mass m_i
///   uniform        1 for each polygon edge           number of neighbours  [Tau95]
///   cotan          1/2 (cot a_ij + cot b_ij)         1                     [YZX*04]
///   cotan_voronoi  1/2 (cot a_ij + cot b_ij)         mixed Voronoi area    [PP93, DMSB99, MDSB03]
///
/// The sums run over all triangles at an edge, so boundaries and non-manifold edges need no
/// special case.
enum class Discretization { uniform, cotan, cotan_voronoi };

/// The metric of the triangles. A triangle whose area is below `least_area` of its longest edge
/// squared is given that area and the weights of an equilateral triangle on top: its matrix stays
/// positive semi-definite and no vertex hangs loose.
struct TriangleMetric
{
    std::vector<std::array<double, 3>> half_cotan; ///< 1/2 cot at corner k, for the edge opposite
    std::vector<double> area;                      ///< as it is, zero included
    std::vector<int> degenerate;                   ///< the floored triangles
};

/// An angle of about 1e-5: what one Laplacian still bears.
constexpr double needle = 1e-5;

/// `needle` for the k-th power of the Laplacian, whose condition grows as (1 / area)^k.
double least_area_for_order(int order);

TriangleMetric triangle_metric(const SurfaceMesh& mesh, double least_area = needle);

/// Faces with a triangle that triangle_metric() floors.
int degenerate_face_count(const SurfaceMesh& mesh, const TriangleMetric& metric);
int degenerate_face_count(const SurfaceMesh& mesh, double least_area = needle);

/// A factor for one element (a triangle, or an edge of `uniform`), from its vertices.
using ElementScale = std::function<double(std::span<const int> vertices)>;

// Each of the following comes twice: for a metric at hand, and for one floored at `least_area`.

/// (n, n) L, each element scaled by `scale` where given (>= 0 keeps L semi-definite). `scale` is called from
/// several threads.
SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const TriangleMetric& metric, const ElementScale& scale = {});
SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const ElementScale& scale = {}, double least_area = needle);

/// (n) masses m_i; their sum is the surface's area for cotan_voronoi. Zero where no face is.
VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric);
VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization);

/// The mass for dividing: at least 1e-6 of the mean, and 1e-2 at degenerate triangles.
VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric);
VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, double least_area = needle);

/// (n, n) the order-k operator in symmetric form, L (M^-1 L)^(k-1) (Eq. 18).
/// \throw InvalidOption  order < 1.
SparseMatrix laplacian_power(const SurfaceMesh& mesh, int order, Discretization discretization);

} // namespace sinew
