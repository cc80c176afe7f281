// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

namespace sinew {

/// (3t, n) G: rows 3k, 3k+1, 3k+2 give x, y, z of the gradient of the piecewise linear
/// interpolant on triangle k (section 4.5.1). Zero rows on triangles without area.
SparseMatrix gradient_matrix(const SurfaceMesh& mesh);

/// (n, 3t) G^T D with D the triangle areas, so that divergence * gradient = L (cotan) where no
/// triangle is degenerate: the integrated, outward-negative divergence, minus the strong one.
SparseMatrix divergence_matrix(const SurfaceMesh& mesh);

} // namespace sinew
