// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Elimination orderings for sparse Cholesky factors (appendix A of the tutorial).
///
///   automatic               minimum degree below 50,000 unknowns, from there on patch dissection
///   natural                 the order of the unknowns; a reference, never fast
///   cuthill_mckee           neighbours close to each other; a reference
///   reverse_cuthill_mckee   the same bandwidth and a smaller factor; for long thin shapes
///   minimum_degree          cheap to find; the factor is 1.2 to 1.5 times the smallest from 200,000 unknowns on
///   nested_dissection       the smallest factor; takes 5 to 6 times as long to find as minimum degree
///   patch_dissection        from 50,000 unknowns on a factor at most 9 % larger, found in a quarter of the time
///
/// The last two need CHOLMOD with METIS; without it, automatic is minimum degree.
enum class Ordering {
    automatic,
    natural,
    cuthill_mckee,
    reverse_cuthill_mckee,
    minimum_degree,
    nested_dissection,
    patch_dissection
};
constexpr auto choices(Ordering)
{
    return std::array{Choice{"automatic", Ordering::automatic},
                      Choice{"natural", Ordering::natural},
                      Choice{"cuthill_mckee", Ordering::cuthill_mckee},
                      Choice{"reverse_cuthill_mckee", Ordering::reverse_cuthill_mckee},
                      Choice{"minimum_degree", Ordering::minimum_degree},
                      Choice{"nested_dissection", Ordering::nested_dissection},
                      Choice{"patch_dissection", Ordering::patch_dissection}};
}

/// p such that row p[i] of the symmetric matrix is eliminated as number i. Only the pattern of the matrix is
/// read.
/// \throw InvalidOption  nested or patch dissection was asked for in a build without it.
std::vector<int> elimination_order(const SparseMatrix& matrix, Ordering ordering);

} // namespace sinew
