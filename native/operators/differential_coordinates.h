// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// Row i of L f for f (n, 3), without the rounding errors of values far from zero.
/// \param L  (n, n) its column i has the weights of row i, negative but for the diagonal, and sums to zero.
template <class Values>
Vector3 laplacian_at(const SparseMatrix& L, const Values& f, int i)
{
    double sum[3] = {0, 0, 0};
    const double* const own = f.data() + 3 * static_cast<std::ptrdiff_t>(i);
    for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
        const double* const other = f.data() + 3 * it.row();
        for (int axis = 0; axis < 3; ++axis)
            sum[axis] += it.value() * (other[axis] - own[axis]);
    }
    return {sum[0], sum[1], sum[2]};
}

/// delta = M^-1 L y, the differential coordinates of y.
void differentiate(const SparseMatrix& L, const VectorX& mass, const PointsView& y, Points& delta);

} // namespace sinew
