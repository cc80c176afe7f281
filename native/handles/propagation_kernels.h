// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// What a share of a handle that moves adds at a point.
struct PropagatedMotion
{
    double numbers[9]; ///< of MapBlend, less those of the identity
    double centre[3], move[3];
    double turning; ///< |R S - I|^2
};

/// The motions of the handles of one part.
struct PropagatedPart
{
    const PropagatedMotion* motions;
    int count;
    double identity[9]; ///< its numbers
    double mean[9];     ///< R of MapBlend, row by row
};

/// Every variant does the same operations in the same order and fuses none, so results agree to the last bit.
struct PropagationKernels
{
    /// Moves points one after the other, up to the first where the blend turns by more than about half a
    /// turn: that one is left to the caller. The arrays are read and written up to a multiple of eight
    /// points.
    /// \param t       how much of motion k reaches point i: t[k * stride + i].
    /// \param from    (n, 3) points.
    /// \param[out] to (n, 3) where they go, as far as they are moved.
    /// \return how many points it moved, n at most.
    int (*move)(const PropagatedPart& part, int n, const double* t, int stride, const double* from,
                double* to);

    static const PropagationKernels baseline, avx2, avx512;
};

} // namespace sinew
