// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <span>
#include <vector>

namespace sinew {

/// The second difference of a function over two triangles (j, k, l), (k, j, m) with a common edge
/// [GSS99, section 3]:
///
///     D f = sqrt(h_l h_m) ((f_l - f(foot of l)) / h_l + (f_m - f(foot of m)) / h_m)
///
/// the jump of the slope across the edge, once the pair is unfolded into a plane; h are the heights above the
/// edge. It is zero for functions that are linear in that plane. Times the root, it does not depend on the
/// size of the mesh, and slender triangles do not outweigh all others.
struct SecondDifference
{
    std::array<int, 4> vertices; ///< j, k, l, m
    std::array<double, 4> weights;
};

/// Those of all edges of exactly two triangles that run along it in opposite directions. Pairs with a
/// triangle of (nearly) no area are left out, and so are triangles with a corner twice.
std::vector<SecondDifference> second_differences(const Points& points, std::span<const Triangle> triangles);

/// (n, n) H + 1e-8 L: with f^T H f = sum (D f)^2, and the cotan Laplacian, which decides what second
/// differences leave open: a surface that one vertex holds, or vertices of faces without area alone. L does
/// not bend linear functions inside a plane, either.
/// \param[out] degenerate_faces  the number of faces with a triangle of (nearly) no area.
SparseMatrix second_difference_matrix(const SurfaceMesh& mesh, int& degenerate_faces);

} // namespace sinew
