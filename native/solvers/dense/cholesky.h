// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/simd/aligned.h"
#include "native/core/types.h"

#include <cstddef>
#include <cstdint>

namespace sinew {

/// A = U^T U for a dense symmetric positive definite A, by blocks. Results agree to the last bit on any
/// number of threads and with any set of instructions.
class DenseCholesky
{
public:
    DenseCholesky() = default;
    /// Makes a matrix of zeros.
    /// \throw OutOfMemory  it would take more than limit_memory() allows.
    explicit DenseCholesky(int size);

    static std::int64_t bytes(int size);

    int size() const { return size_; }
    /// Row i of A, of which entries from i on are read; afterwards of U.
    double* row(int i) { return entries_.data() + static_cast<std::size_t>(i) * stride_; }
    const double* row(int i) const { return entries_.data() + static_cast<std::size_t>(i) * stride_; }

    /// Replaces A by U, so call it once. Cost: size^3 / 3 operations.
    /// \param stage  for the progress, which goes from 0 to 1.
    /// \return the unknown at which A proves not to be positive definite, up to rounding; -1 if it is.
    /// \throw Cancelled
    int factorize(const Progress& progress, const char* stage);
    /// x (size, k) = A^-1 x. Cost: 2 size^2 k operations. Several threads may call it at once.
    void solve(RowMatrix& x) const;

private:
    int size_ = 0;
    std::size_t stride_ = 0;
    AlignedVector<double> entries_;
};

} // namespace sinew
