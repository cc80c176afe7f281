// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/solvers/linear_system.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace sinew {

/// A graph in space with an operator, one level of a hierarchy. Nodes are numbered in an order of their own: first the
/// free ones, then the held ones with a free neighbour, each along a curve that fills space.
///
///     (L x)_i = sum_j w_ij (x_i - x_j),    A = L + pull    or    A = L (M^-1 L + membrane) + pull
struct Level
{
    struct Link
    {
        int node;
        float weight;
    };

    int free = 0, nodes = 0;
    std::vector<int> link_begin; ///< (nodes + 1)
    std::vector<Link> links;     ///< of each node by rising numbers of the others
    std::vector<float>
        rounding; ///< (links) weights less what `links` has; on the finest level of a system without a matrix
    std::vector<float> pull; ///< (free)
    Points points; ///< (nodes, 3); of the last level alone, once the next one is made
    VectorX mass; ///< (nodes); likewise
    std::vector<float> inverse_mass; ///< (nodes)
    std::vector<float> inverse_of_L; ///< (free) of the diagonal; 0 where a node has no links
    std::vector<float> inverse_diagonal; ///< (free) of A

    // To the next level. A node follows up to three coarse ones with shares of the sum 1.
    std::vector<std::array<int, 3>> parents; ///< (nodes)
    std::vector<std::array<float, 3>> shares; ///< (nodes)
    std::vector<int> child_begin; ///< (coarse nodes + 1)
    std::vector<Link> children; ///< the transpose

    /// Of a link, in double precision where that is known.
    double weight(int at) const
    {
        return rounding.empty() ? links[at].weight : static_cast<double>(links[at].weight) + rounding[at];
    }
    std::int64_t bytes() const;
};

/// Coarser and coarser graphs. Cells of nodes within one ring of a seed (two, for operators of the first order) become
/// the nodes of the next level, at their barycentres; a node follows the triangle of touching cells that it is in.
/// L and M of a level are those of the level above between such functions, A is made of them anew.
///
/// L. Kobbelt, S. Campagna, J. Vorsatz, H.-P. Seidel. "Interactive multi-resolution modeling on arbitrary meshes."
/// SIGGRAPH 1998; B. Aksoylu, A. Khodakovsky, P. Schröder. "Multilevel solvers for unstructured surface meshes." SIAM
/// J. Sci. Comput. 26(4), 2005. Departs from both: no faces are collapsed, so that any graph will do.
struct Hierarchy
{
    int order = 1; ///< of the operator: 1 or 2
    double membrane = 0; ///< in the units of the hierarchy, in which weights and masses are about 1
    double weight = 1; ///< of the system that is 1 in the hierarchy
    double scale = 1; ///< x of the system for the same b, as a multiple of x of the hierarchy
    std::vector<int>
        unknowns; ///< (free) the unknown of the system that each free node of the finest level is
    std::vector<int>
        held; ///< (nodes - free) the node of the system that each held one of the finest level is
    std::vector<Level> levels; ///< from fine to coarse; never empty

    /// Cost: O(n), the time of some ten products with A.
    /// \param system  with a matrix, or with pulls.
    /// \throw InvalidOption  the system has no nodes, or an order of 3 and more.
    /// \throw Cancelled
    explicit Hierarchy(const LinearSystem& system, const Progress& progress = {});

    std::int64_t bytes() const;
};

} // namespace sinew
