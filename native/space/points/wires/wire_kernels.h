// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Contacts of points with wires, as the kernels read them: four to a block.
struct WireContacts
{
    const int* firsts;    ///< contact k has the shares [firsts[k], firsts[k + 1])
    const int* samples;   ///< for each share
    const double* shares; ///< likewise
    const double* blocks; ///< (blocks, 5, 4) x, y and z of x - R(p); F; (s - 1) F
};

/// Memory limits their speed, so eight lanes would not be faster than four. Every variant does the same
/// operations in the same order and fuses none, so results agree to the last bit.
struct WireKernels
{
    /// The moves by which wires carry points.
    /// \param table       (samples, 8) the move of each sample and 0, then its turn, axis times angle, and 0
    /// \param first       block
    /// \param[out] moves  (4 blocks, 4) a move and 0 per contact
    void (*moves)(const WireContacts& contacts, const double* table, int first, int blocks, double* moves);

    static const WireKernels baseline, avx2;
};

} // namespace sinew
