// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/report.h"

#include <cstdint>
#include <functional>
#include <string>

namespace sinew {

/// How a method solves its system.
///
///   automatic  factor; multigrid where the factor takes more memory than limit_memory() allows, or without a limit than
///              the machine has
///   factor     a Cholesky factor, computed once: a frame takes two triangular solves
///   multigrid  iterations in each frame, in a fifth of the memory for a bi-Laplacian, in three fifths for a Laplacian
enum class SystemSolver { automatic, factor, multigrid };
constexpr auto choices(SystemSolver)
{
    return std::array{Choice{"automatic", SystemSolver::automatic}, Choice{"factor", SystemSolver::factor},
                      Choice{"multigrid", SystemSolver::multigrid}};
}
template <class Options>
constexpr auto solver_option(SystemSolver Options::* member)
{
    return option(
        "solver", member, Rebind::update,
        "'factor', 'multigrid' (iterations in little memory, to 1e-4 of the motion), or 'automatic': "
        "the multigrid where the factor does not fit limit_memory(), or the machine");
}

/// About what the factor of a surface takes, in bytes: the entries of a row grow with the logarithm of their number.
/// \param order  1 for a Laplacian, 2 for a bi-Laplacian.
double factor_bytes(int free, int order);

/// A system that is bound by a factor or on a multigrid.
struct TwoWays
{
    int free; ///< vertices
    double factor_bytes; ///< an estimate
    std::string unsuited; ///< why the multigrid cannot solve the system; empty where it can
    std::function<void()> factorize, iterate; ///< each leaves the method as it was if it throws
};

/// Binds a system the way that the option asks for. With `automatic`, the factor is not even begun where its estimate
/// is beyond all doubt, and the multigrid takes its place where it does not fit.
/// \return  why the multigrid took the place of the factor, for remark_iterations(); empty where it did not, and where
///   it was asked for.
/// \throw InvalidOption  the multigrid is asked for and cannot solve the system.
/// \throw OutOfMemory    nothing fits; the message names what both ways need.
std::string bind_by(SystemSolver solver, const TwoWays& ways);

/// "solved by iterations on a multigrid in 2.6 GB: ...", from the factor_bytes of the report, unless `why` is empty.
void remark_iterations(BindReport& report, const std::string& why);

} // namespace sinew
