// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/harmonic/data.h"
#include "native/methods/space/cage/harmonic/lattice.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace sinew {

/// Harmonic functions at the nodes of a lattice inside a cage, for sixteen neighbouring cage vertices at a
/// time.
///
/// A node has links along each axis: to its neighbour, or to the point where the link crosses the cage and
/// the data are known. The differences over these links (G. Shortley, R. Weller 1938; F. Gibou et al., J.
/// Comput. Phys. 176, 2002) have weights of one sign, so that values lie between the data, and are exact for
/// linear functions. They are solved from coarse to fine by V-cycles of Gauss-Seidel sweeps in two colours
/// (A. Brandt 1977). Each level has its own crossings. The finer levels are solved only in a window around
/// the faces at the vertices, as the functions are smooth everywhere else.
class HarmonicMultigrid
{
public:
    static constexpr int strip = 16; ///< number of functions at once: a cache line of single numbers
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
    /// The workspace for one strip at a time.
    struct Work
    {
        struct Rows
        {
            std::vector<int> reds, blacks;
        };
        std::vector<std::vector<Row>> values, sources, residuals; ///< per level; the last row of values is 0
        std::vector<Rows> solved, cleared; ///< per level: nodes of the window; these and those next to them
    };

    /// \throw OutOfMemory  this needs more than limit_memory() allows.
    HarmonicMultigrid(const HarmonicLattice& lattice, const Cage& cage,
                      const std::vector<HarmonicData>& data);

    int level_count() const { return static_cast<int>(levels_.size()); }
    /// The finest level that is solved everywhere, not only in windows.
    int base() const { return base_; }
    int node_count() const { return levels_[0].count; }
    int strip_count() const { return static_cast<int>(stars_.size()); }
    /// The cage vertices of a strip.
    std::span<const int> vertices(int strip_index) const;
    /// The place of a vertex among the vertices of all strips.
    int place(int vertex) const { return place_[vertex]; }
    std::int64_t bytes() const;
    /// Memory of one Work.
    std::int64_t work_bytes() const;
    /// The share that a level has in the value at a point that is interpolated from nodes up to `reach` steps
    /// away: 1 in the level's window, falling to 0 towards its sides.
    double share(int strip_index, int level, const Vector3& at, double reach) const;

    /// \param done  called after each level converges, when `work` has the values in its window; the last
    ///              level is 0, the finest.
    /// \return the largest residual: the difference between a value and the mean that its neighbours give.
    double solve(int strip_index, Work& work, const std::function<void(int level)>& done) const;

    /// The row of a node of a level; -1 if it is not inside, or in no window. The coordinates of the node are
    /// multiples of 2^level.
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
        std::array<int, 8> row; ///< on the next level, or that level's `count` if absent
    };
    struct Level
    {
        /// Numbers of rows: red nodes, whose coordinates have an even sum, come first; `count` are all.
        int reds = 0, count = 0;
        std::vector<std::array<int, 6>> link; ///< the rows down and up each axis; `count` across the cage
        std::vector<std::array<float, 6>> share; ///< of the values of the neighbours in that of the node
        std::vector<float> diagonal; ///< the coefficient of a node in the sum of its second differences
        std::vector<std::vector<Source>> sources; ///< the data, per strip
        std::vector<Parents> parents; ///< of each black node
        std::vector<std::array<int, 13>> children; ///< red nodes of the next finer level
        std::vector<int> rows; ///< of all nodes of the lattice, -1 for none
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
    std::vector<int> order_; ///< the vertices, strip by strip
    std::vector<int> place_; ///< the place of each vertex in order_
    std::vector<Window> stars_; ///< the box around the faces at the vertices of each strip
};

} // namespace sinew
