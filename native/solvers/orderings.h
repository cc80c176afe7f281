// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Elimination orderings for sparse Cholesky factors (appendix A of the tutorial).
///
///   natural                 the order of the unknowns; a reference, never fast
///   reverse_cuthill_mckee   a small bandwidth; for long thin shapes
///   minimum_degree          cheap to find; the default
///   nested_dissection       a smaller factor on large surfaces; takes 5 to 6 times as long to find, which
///                           pays off after 65 to 100 solves. Needs CHOLMOD with METIS.
enum class Ordering { natural, reverse_cuthill_mckee, minimum_degree, nested_dissection };
constexpr auto choices(Ordering)
{
    return std::array{Choice{"natural", Ordering::natural},
                      Choice{"reverse_cuthill_mckee", Ordering::reverse_cuthill_mckee},
                      Choice{"minimum_degree", Ordering::minimum_degree},
                      Choice{"nested_dissection", Ordering::nested_dissection}};
}

/// p such that row p[i] of the symmetric matrix is eliminated as number i. Only the pattern of the matrix is
/// read.
/// \throw InvalidOption  nested dissection was asked for in a build without it.
std::vector<int> elimination_order(const SparseMatrix& matrix, Ordering ordering);

} // namespace sinew
