// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Row by row with 32-bit indices: SciPy's CSR.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// A sparse matrix that is applied to points every frame.
///
/// Cost of apply(): one pass over the entries, 8 bytes each in float and 12 in double. The sum of a row is
/// formed in one order, so results agree to the last bit on any number of threads and with any instruction
/// set.
class Stencils
{
public:
    Stencils() = default;
    explicit Stencils(SparseRows&& matrix);

    /// (n, k) in double, as it was given.
    const SparseRows& matrix() const { return matrix_; }

    /// \param points  (k, 3)
    /// \param to      (n, 3), no part of `points`
    void apply(const double* points, double* to) const;
    /// The same in float, with the weights rounded to it.
    void apply(const float* points, float* to) const;

private:
    SparseRows matrix_;
    std::vector<float> single_; ///< the weights
};

} // namespace sinew
