// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/engines/factor_engine.h"

namespace sinew {

/// Whether the build has CHOLMOD.
bool have_cholmod();

/// CHOLMOD with one dense block per supernode (fast for bi-Laplacians), or with one column at a time (faster
/// solves for small Laplacians). Null in a build without CHOLMOD.
std::unique_ptr<FactorEngine> make_cholmod_factor(bool supernodal);

/// Minimum degree by AMD, which is a part of CHOLMOD. Call it only in a build with CHOLMOD.
std::vector<int> cholmod_minimum_degree(const SparseMatrix& matrix);

/// Nested dissection by METIS, through CHOLMOD.
/// \throw InvalidOption  the build does not have it.
std::vector<int> nested_dissection(const SparseMatrix& matrix);

} // namespace sinew
