// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <functional>
#include <span>
#include <vector>

namespace sinew {

// Conventions for the whole library. The Laplacian matrix L is symmetric positive semi-definite, weak (not
// divided by area), and in double precision:
//
//     (L f)_i = sum_j w_ij (f_i - f_j),    Delta f = -M^-1 L f,    M = diag(mass).
//
// L is minus the symmetric matrix of the tutorial's appendix, with the factors of its Eq. 7.

/// Discretisations of section 3.2.
///
///   name           w_ij                              mass m_i
///   uniform        1 for each polygon edge           number of neighbours  [Tau95]
///   cotan          1/2 (cot a_ij + cot b_ij)         1                     [YZX*04]
///   cotan_voronoi  1/2 (cot a_ij + cot b_ij)         mixed Voronoi area    [PP93, DMSB99, MDSB03]
///   robust         cotan_voronoi of the triangles of operators/tufted_cover.h, which have no w_ij < 0
///
/// The sums run over all triangles at an edge, so boundaries and non-manifold edges are no special cases.
/// `robust` is the same as cotan_voronoi, to the last bit, where no triangle is close to a line, the angles
/// opposite to an edge have a sum of pi or less, and none opposite to a border is obtuse. Elsewhere its
/// neighbours need not be those of the mesh, and it costs a triangulation more per matrix and mass.
enum class Discretization { uniform, cotan, cotan_voronoi, robust };
constexpr auto choices(Discretization)
{
    return std::array{Choice{"uniform", Discretization::uniform}, Choice{"cotan", Discretization::cotan},
                      Choice{"cotan_voronoi", Discretization::cotan_voronoi},
                      Choice{"robust", Discretization::robust}};
}

/// The metric of the triangles. A triangle whose area is below `least_area` of its longest edge squared is
/// treated as degenerate: it gets that area, and the weights of an equilateral triangle in addition to its
/// own. Its matrix stays positive semi-definite, and all its vertices stay connected.
struct TriangleMetric
{
    std::vector<std::array<double, 3>> half_cotan; ///< 1/2 cot at corner k, for the edge opposite
    std::vector<double> area;                      ///< the true area, which may be zero
    std::vector<int> degenerate;                   ///< the degenerate triangles
};

/// The least area for a system with one Laplacian: that of a triangle with an angle of about 1e-5.
constexpr double needle = 1e-5;

/// The same for the k-th power of the Laplacian, whose condition number grows as (1 / area)^k.
double least_area_for_order(int order);

TriangleMetric triangle_metric(const SurfaceMesh& mesh, double least_area = needle);

/// The number of faces with a degenerate triangle.
int degenerate_face_count(const SurfaceMesh& mesh, const TriangleMetric& metric);
int degenerate_face_count(const SurfaceMesh& mesh, double least_area = needle);

/// Gives a factor for one element (a triangle, or with `uniform` an edge) from its vertices.
using ElementScale = std::function<double(std::span<const int> vertices)>;

// Each of the following has two versions: for a metric that the caller has, and for a `least_area`. With
// `robust`, both look at neither but for the masses of degenerate triangles.

/// (n, n) L. If there is a `scale`, it scales each element (factors >= 0 keep L semi-definite); it is called
/// from several threads.
SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const TriangleMetric& metric, const ElementScale& scale = {});
SparseMatrix laplacian_matrix(const SurfaceMesh& mesh, Discretization discretization,
                              const ElementScale& scale = {}, double least_area = needle);

/// Turns negative weights w_ij of L into positive ones of a millionth of their size. Functions that are
/// harmonic for positive weights stay between the values that are given; none is cut to zero, so that no
/// vertex loses its last edge. Where this changes anything, each diagonal entry becomes the sum of its
/// weights.
/// \return whether there were negative weights, beyond rounding.
bool make_weights_positive(SparseMatrix& L);

/// (n) masses m_i. With cotan_voronoi their sum is the area of the surface, also with robust unless lengths grew. Vertices in no face have zero.
VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric);
VectorX mass_vector(const SurfaceMesh& mesh, Discretization discretization);

/// Masses that one may divide by: at least 1e-6 of their mean, and 1e-2 of it at degenerate triangles.
VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, const TriangleMetric& metric);
VectorX divisible_mass(const SurfaceMesh& mesh, Discretization discretization, double least_area = needle);

/// (n, n) the operator of order k in symmetric form, L (M^-1 L)^(k-1) (Eq. 18).
/// \throw InvalidOption  order < 1.
/// \throw InvalidMesh    the entries, lengths to the power of 2 - 2k, would not be finite, or all be 0.
SparseMatrix laplacian_power(const SurfaceMesh& mesh, int order, Discretization discretization);

} // namespace sinew
