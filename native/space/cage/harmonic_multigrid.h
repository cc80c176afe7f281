// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Part of the method harmonic.

#include "native/space/cage/harmonic_data.h"
#include "native/space/cage/harmonic_lattice.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace sinew {

/// Harmonic functions at the nodes of a lattice inside a cage, sixteen cage vertices at a time.
///
/// Differences over a node's links along each axis, to its neighbour or to where the link crosses the cage and
/// the data are known (G. Shortley, R. Weller 1938; F. Gibou et al., J. Comput. Phys. 176, 2002): weights of
/// one sign, so that values lie between the data, and exact for linear functions. Solved from coarse to fine
/// by V-cycles of Gauss-Seidel sweeps in two colours (A. Brandt 1977), each level with its own crossings.
class HarmonicMultigrid
{
public:
    static constexpr int strip = 16; ///< functions at once: a cache line of single numbers
    struct alignas(64) Row
    {
        float at[strip];
    };
    /// Of one strip; may be used again.
    struct Work
    {
        std::vector<std::vector<Row>> values, sources, residuals; ///< a level; the last row of values is 0
    };

    HarmonicMultigrid(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data, int columns);

    int level_count() const { return static_cast<int>(levels_.size()); }
    int node_count() const { return levels_[0].count; }
    /// Memory of one Work.
    std::int64_t work_bytes() const;

    /// \param done  is told each level whose values stand; the last one is 0, the finest.
    /// \return the largest residual left: by how much a value is not what its neighbours say.
    double solve(int first_column, Work& work, const std::function<void(int level)>& done) const;

    /// The row of a level's node, a multiple of 2^level; -1 where it is not inside.
    int row(int level, const HarmonicLattice::Node& node) const;

private:
    struct Source
    {
        int row, lane;
        float value;
    };
    struct Parents
    {
        int count; ///< 2 or 8
        std::array<int, 8> row; ///< on the next level, `its count` for none
    };
    struct Level
    {
        int reds = 0, count = 0; ///< rows: first the nodes whose coordinates have an even sum
        std::vector<std::array<int, 6>> link;    ///< down and up each axis; `count` across the cage
        std::vector<std::array<float, 6>> share; ///< of each neighbour's value in the node's
        std::vector<float> diagonal;             ///< the node's own in the sum of its second differences
        std::vector<std::vector<Source>> sources; ///< data, a strip
        std::vector<Parents> parents;             ///< of each black
        std::vector<std::array<int, 13>> children; ///< reds of the level before
        std::vector<int> rows;                     ///< of all nodes
        HarmonicLattice::Node size;
    };

    void number(const HarmonicLattice& lattice, int level);
    void link(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data, int level, int strips);
    void nest(int level);
    void relax(int level, int begin, int end, Work& work) const;
    double find_residual(int level, Work& work) const;
    void cycle(int level, Work& work, double* residual) const;
    void prolong(int level, Work& work, bool correct) const;

    std::vector<Level> levels_;
};

} // namespace sinew
