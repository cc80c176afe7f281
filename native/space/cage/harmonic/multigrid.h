// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/harmonic/data.h"
#include "native/space/cage/harmonic/lattice.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace sinew {

/// Harmonic functions at the nodes of a lattice inside a cage, sixteen neighbouring cage vertices at a time.
///
/// Differences over a node's links along each axis, to its neighbour or to where the link crosses the cage
/// and the data are known (G. Shortley, R. Weller 1938; F. Gibou et al., J. Comput. Phys. 176, 2002): weights
/// of one sign, so that values lie between the data, and exact for linear functions. Solved from coarse to
/// fine by V-cycles of Gauss-Seidel sweeps in two colours (A. Brandt 1977), each level with its own
/// crossings. The finer levels are solved in a window around the faces at the vertices alone, as everywhere
/// else the functions are smooth.
class HarmonicMultigrid
{
public:
    static constexpr int strip = 16; ///< functions at once: a cache line of single numbers
    struct alignas(64) Row
    {
        float at[strip];
    };
    using Node = HarmonicLattice::Node;
    /// Nodes of the finest level, the last ones included.
    struct Window
    {
        Node low, high;
    };
    /// Of one strip; may be used again.
    struct Work
    {
        struct Rows
        {
            std::vector<int> reds, blacks;
        };
        std::vector<std::vector<Row>> values, sources, residuals; ///< a level; the last row of values is 0
        std::vector<Rows> solved, cleared; ///< a level: nodes of the window, and around
    };

    /// \throw OutOfMemory  more than limit_memory() allows.
    HarmonicMultigrid(const HarmonicLattice& lattice, const Cage& cage,
                      const std::vector<HarmonicData>& data);

    int level_count() const { return static_cast<int>(levels_.size()); }
    /// The finest level that is solved everywhere.
    int base() const { return base_; }
    int node_count() const { return levels_[0].count; }
    int strip_count() const { return static_cast<int>(stars_.size()); }
    /// The cage vertices of a strip.
    std::span<const int> vertices(int strip_index) const;
    /// Where among the vertices of all strips one is.
    int place(int vertex) const { return place_[vertex]; }
    std::int64_t bytes() const;
    /// Memory of one Work.
    std::int64_t work_bytes() const;
    /// The part of a level's answer that counts at a point that needs nodes up to `reach` from it: 1 in the
    /// level's window, falling to 0 towards its sides.
    double share(int strip_index, int level, const Vector3& at, double reach) const;

    /// \param done  is told each level whose values stand, in its window; the last one is 0, the finest.
    /// \return the largest residual left: by how much a value is not what its neighbours say.
    double solve(int strip_index, Work& work, const std::function<void(int level)>& done) const;

    /// The row of a level's node, a multiple of 2^level; -1 where it is not inside or in no strip's window.
    int row(int level, const Node& node) const;

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
        std::vector<std::array<int, 6>> link; ///< down and up each axis; `count` across the cage
        std::vector<std::array<float, 6>> share; ///< of each neighbour's value in the node's
        std::vector<float> diagonal; ///< the node's own in the sum of its second differences
        std::vector<std::vector<Source>> sources; ///< data, a strip
        std::vector<Parents> parents; ///< of each black
        std::vector<std::array<int, 13>> children; ///< reds of the level before
        std::vector<int> rows; ///< of all nodes
        Node size;
    };

    void order(const HarmonicLattice& lattice, const Cage& cage);
    void number(const HarmonicLattice& lattice, int level);
    void link(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data, int level);
    void nest(int level);
    template <class Visit>
    static void each_row(const Level& level, Visit&& visit);
    Window window(int strip_index, int level) const;
    std::array<Node, 2> range(int level, const Window& window, int around) const;
    Work::Rows rows(int level, const Window& window, int around) const;
    Row wanted(int level, int row, const Work& work) const;
    void relax(int level, const std::vector<int>& rows, Work& work) const;
    double find_residual(int level, Work& work) const;
    double cycle(int level, Work& work, bool correct) const;
    void prolong(int level, const std::vector<int>& rows, Work& work, bool correct) const;

    std::vector<Level> levels_;
    int base_ = 0;
    std::vector<int> order_, place_; ///< vertices strip by strip; where each is
    std::vector<Window> stars_; ///< around the faces at a strip's vertices
};

} // namespace sinew
