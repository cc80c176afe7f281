// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/supernodal/principal_block.h"
#include "native/solvers/supernodal/tree.h"

#include <vector>

namespace sinew {

/// The supernodes that have one of the given positions, and all above them in the tree: the part of the
/// factor that changes if these columns of the matrix change.
std::vector<char> supernodes_above(const SupernodalFactor& factor, const std::vector<int>& positions);

/// The number of floating-point operations that the numeric factorisation of each supernode takes, including
/// those that subtract the contributions of supernodes below.
std::vector<double> supernodal_work(const SupernodalFactor& factor);

/// Numeric Cholesky factorisation for a given symbolic one. It is left-looking: a supernode takes its columns
/// of A, subtracts the contributions of the supernodes below it, in their order, and is factorised as a dense
/// block.
///
/// E. G. Ng, B. W. Peyton. "Block sparse Cholesky algorithms on advanced uniprocessor computers."
/// SIAM Journal on Scientific Computing 14(5), 1993.
///
/// Subtrees run in parallel. The supernodes above them follow one by one, and their panels run in parallel.
/// The order of all sums depends on the structure alone, so any number of threads gives the same bits.
/// Computing only the `chosen` supernodes, after a change that affects no others, gives them, too.
///
/// \param block     its pattern is the analysed one or a part of it.
/// \param chosen    (supernodes) those to compute, closed under supernodes_above(); empty for all.
/// \param parallel  false if the BLAS allows only one caller at a time.
/// \return the position at which it broke down, or -1.
int factorize_supernodal(const SupernodalFactor& factor, const PrincipalBlock& block,
                         const std::vector<char>& chosen = {}, bool parallel = true);

} // namespace sinew
