// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

namespace sinew {

/// (3t, n) G: rows 3k, 3k+1, 3k+2 give x, y, z of the gradient of the piecewise linear interpolant on
/// triangle k (section 4.5.1 of the tutorial). The rows of triangles without area are zero.
SparseMatrix gradient_matrix(const SurfaceMesh& mesh);

/// (n, 3t) G^T D, where D holds the areas of the triangles. divergence * gradient = L (cotan) where no
/// triangle is degenerate, so this is minus the divergence, integrated over the cell of each vertex.
SparseMatrix divergence_matrix(const SurfaceMesh& mesh);

} // namespace sinew
