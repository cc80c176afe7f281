// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// Contacts of points with wires, as the kernels read them: four to a block. Their shares are side by side,
/// so that four sums run beside each other; a contact with fewer of them than another one of its block has
/// shares of zero at its end. In a stretch of rows each contact follows one sample after the other.
struct WireContacts
{
    const int* firsts;    ///< block b has the stretches [firsts[b], firsts[b + 1])
    const int* rows;      ///< stretch s has the rows [rows[s], rows[s + 1])
    const int* samples;   ///< (stretches, 4) where they begin
    const double* shares; ///< (rows, 4)
    const double* blocks; ///< (blocks, 5, 4) x, y and z of x - R(p); F; (s - 1) F
};

/// Memory limits their speed, so eight lanes would not be faster than four. Every variant does the same
/// operations in the same order and fuses none, so results agree to the last bit.
struct WireKernels
{
    /// The moves by which wires carry points.
    /// \param table       (samples, 8) the move of each sample and 0, then its turn, axis times angle, and 0.
    ///                    Behind them are as many rows of zeros as the longest block has.
    /// \param first       block
    /// \param[out] moves  (4 blocks, 4) a move and 0 per contact
    void (*moves)(const WireContacts& contacts, const double* table, int first, int blocks, double* moves);

    static const WireKernels baseline, avx2;
};

} // namespace sinew
