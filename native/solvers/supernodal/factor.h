// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/supernodal/principal_block.h"
#include "native/solvers/supernodal/tree.h"

#include <vector>

namespace sinew {

/// The supernodes that hold one of the given positions, and all above them in the tree: what a change of
/// those columns of the matrix changes in the factor.
std::vector<char> supernodes_above(const SupernodalFactor& factor, const std::vector<int>& positions);

/// Floating-point operations of the numeric factorisation of each supernode, what flows in from below
/// included.
std::vector<double> supernodal_work(const SupernodalFactor& factor);

/// Numeric Cholesky factorisation on a symbolic one, left-looking: a supernode takes its columns of A,
/// subtracts what those below it contribute, in their order, and is factorised as a dense block.
///
/// E. G. Ng, B. W. Peyton. "Block sparse Cholesky algorithms on advanced uniprocessor computers."
/// SIAM Journal on Scientific Computing 14(5), 1993.
///
/// Subtrees run in parallel; the supernodes above them follow one by one, each parallel within. Which sums
/// are formed in which order depends on the structure alone: any number of threads gives the same bits, and
/// so does recomputing only `chosen` after a change that touched no others.
///
/// \param block     of the analysed pattern or less.
/// \param chosen    (supernodes) the ones to compute, closed under supernodes_above(); empty: all.
/// \param parallel  false where the BLAS bears one caller at a time.
/// \return the position at which it broke down, or -1.
int factorize_supernodal(const SupernodalFactor& factor, const PrincipalBlock& block,
                         const std::vector<char>& chosen = {}, bool parallel = true);

} // namespace sinew
