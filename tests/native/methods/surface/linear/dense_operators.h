// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/operators/laplacian.h"
#include "tests/native/shapes.h"

#include <functional>
#include <vector>

namespace sinew {

// Laplacians and masses once more, by angles and circumcentres, as dense matrices.

double angle_between(const Vector3& at, const Vector3& a, const Vector3& b);

/// L, with each element scaled if there is a `scale`.
MatrixX dense_laplacian(
    const SurfaceMesh& mesh, Discretization kind,
    const std::function<double(const std::vector<int>&)>& scale = [](const std::vector<int>&) {
        return 1.0;
    });

VectorX dense_mass(const SurfaceMesh& mesh, Discretization kind);

} // namespace sinew
