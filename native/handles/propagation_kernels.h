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
    /// Moves four points.
    /// \param t       (count, 4) how much of each motion reaches each point.
    /// \param from    (4, 3) points.
    /// \param[out] to (4, 3) where they go.
    /// \return whether it did; it leaves blends that turn by more than about half a turn to the caller.
    bool (*move)(const PropagatedPart& part, const double* t, const double* from, double* to);

    static const PropagationKernels baseline, avx2;
};

} // namespace sinew
