// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// Products of matrices with many rows and few columns, by several threads. Results agree to the last bit on
/// any number of threads and with any set of instructions.

/// A^T B of the first columns of A (rows, >= columns), with B (rows, k).
MatrixX transposed_product(const MatrixX& A, Eigen::Index columns, const MatrixX& B);

/// B -= A X, with the first columns of A (rows, >= columns), X (columns, k) and B (rows, k).
void subtract_product(const MatrixX& A, Eigen::Index columns, const MatrixX& X, MatrixX& B);

} // namespace sinew
