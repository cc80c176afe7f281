// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/engines/factor_engine.h"

namespace sinew {

/// Eigen's simplicial LDL^T. Every build has it; with CHOLMOD, it is the reference.
std::unique_ptr<FactorEngine> make_ldlt_factor();

} // namespace sinew
