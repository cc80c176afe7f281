// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/engines/factor_engine.h"

namespace sinew {

/// Eigen's simplicial LDL^T: always there, a reference for CHOLMOD.
std::unique_ptr<FactorEngine> make_ldlt_factor();

} // namespace sinew
