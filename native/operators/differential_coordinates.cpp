// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/differential_coordinates.h"

#include "native/core/parallel.h"

namespace sinew {

void differentiate(const SparseMatrix& L, const VectorX& mass, const PointsView& y, Points& delta)
{
    const int n = static_cast<int>(y.rows());
    delta.resize(n, 3);
    parallel_for(n, [&](int i) { delta.row(i) = laplacian_at(L, y, i).transpose() / mass[i]; });
}

} // namespace sinew
