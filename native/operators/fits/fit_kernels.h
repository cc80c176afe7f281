// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Fits of rotation_fit.h, four side by side. Every variant does the same operations in the same order and
/// fuses none, so results agree to the last bit.
struct FitKernels
{
    /// \param S       (4, 9) four matrices, row by row.
    /// \param[out] R  (4, 9) the rotations closest to them, likewise.
    /// \return bit k: whether rotation k is safe; otherwise fit_rotation_svd() has to take over.
    int (*fit)(const double* S, double* R);

    static const FitKernels baseline, avx2;
};

} // namespace sinew
