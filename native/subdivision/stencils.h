// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Stored row by row with 32-bit indices, as SciPy's CSR matrices.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// A sparse matrix that is applied to points in every frame.
///
/// Cost of apply(): one pass over the entries, which take 8 bytes each in float and 12 in double. Each row is
/// summed in a fixed order, so results agree to the last bit on any number of threads and with any set of
/// instructions.
class Stencils
{
public:
    Stencils() = default;
    explicit Stencils(SparseRows&& matrix);

    /// (n, k) in double, as it was given.
    const SparseRows& matrix() const { return matrix_; }

    /// \param points  (k, 3)
    /// \param to      (n, 3), which must not overlap `points`
    void apply(const double* points, double* to) const;
    /// The same in float, with the weights rounded to float.
    void apply(const float* points, float* to) const;

private:
    SparseRows matrix_;
    std::vector<float> single_; ///< the weights in single precision
};

} // namespace sinew
