// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/engines/factor_engine.h"

namespace sinew {

/// True in a build with CHOLMOD.
bool have_cholmod();

/// CHOLMOD, one dense block a supernode (fast for bi-Laplacians) or one column at a time
/// (faster solves for small Laplacians). Null in a build without CHOLMOD.
std::unique_ptr<FactorEngine> make_cholmod_factor(bool supernodal);

/// AMD through CHOLMOD; only in a build with it.
std::vector<int> cholmod_minimum_degree(const SparseMatrix& matrix);

/// METIS' nested dissection through CHOLMOD.
/// \throw InvalidOption  the build has none.
std::vector<int> nested_dissection(const SparseMatrix& matrix);

} // namespace sinew
