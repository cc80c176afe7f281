// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// Unknowns from which on the smaller factor is worth the time that patch dissection takes more than minimum degree.
constexpr int fewest_to_dissect = 50'000;

/// Nested dissection for the matrices of surfaces. A separator is eliminated after the two halves that it separates. No
/// fill comes between these, and they are dissected in parallel.
///
///   1. Patches of some thirty nodes, and the graph of those that touch. METIS halves this small graph.
///   2. The smallest vertex separator within two rings of the border of the halves, by maximum flow.
///   3. Parts of at most 1000 nodes are ordered by minimum degree, where degrees count the separators around them.
///
/// A. George. "Nested dissection of a regular finite element mesh." SIAM J. Numer. Anal. 10, 1973, pp. 345-363.
/// Step 3: F. Pellegrini, J. Roman, P. Amestoy. "Hybridizing nested dissection and halo approximate minimum degree for
/// efficient sparse matrix ordering." Concurrency 12, 2000, pp. 69-84.
///
/// The order depends on the pattern alone, not on the number of threads.
///
/// Cost: in the order of the entries of the matrix, and for each level of halves of those near its separators.
/// Call it only in a build with CHOLMOD.
/// \return p such that row p[i] is eliminated as number i.
std::vector<int> patch_dissection(const SparseMatrix& matrix);

} // namespace sinew
