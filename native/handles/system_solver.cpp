// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/system_solver.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/system/physical_memory.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

/// Why the factor is not even begun: empty where it may fit.
std::string too_large(const TwoWays& ways)
{
    constexpr int small = 200'000; // of so few, the analysis that tells the true size takes no time
    constexpr double least = 0.8;  // what a real one takes at least, as a share of the estimate
    const std::int64_t limit = memory_limit(), most = limit > 0 ? limit : physical_memory();
    if (ways.free < small || most <= 0 ||
        ways.factor_bytes * (limit > 0 ? least : 1.0) <= static_cast<double>(most))
        return {};
    return "the factor needs about " + in_words(static_cast<std::int64_t>(ways.factor_bytes)) + ", the " +
           (limit > 0 ? "memory limit is " : "machine has ") + in_words(most);
}

} // namespace

double factor_bytes(int free, int order)
{
    const double doublings = std::max(std::log2(free / 5e4), 0.0);
    return 8.0 * free * (order == 1 ? 31 + 5 * doublings : 110 + 14 * doublings);
}

std::string bind_by(SystemSolver solver, const TwoWays& ways)
{
    const std::string& no = ways.unsuited;
    if (solver == SystemSolver::multigrid && !no.empty())
        throw InvalidOption("solver: " + no + "; choose the factor");
    const bool may_choose = solver == SystemSolver::automatic && no.empty();
    std::string why = may_choose ? too_large(ways) : "";
    if (why.empty() && solver != SystemSolver::multigrid)
        try {
            ways.factorize();
            return {};
        } catch (const OutOfMemory& error) {
            if (!may_choose)
                throw;
            const std::string text = error.what();
            why = text.substr(0, text.find(':')); // up to what to do
        }
    try {
        ways.iterate();
    } catch (const OutOfMemory& error) {
        if (!may_choose)
            throw;
        throw OutOfMemory(why.substr(0, why.find(',')) + " and " + error.what());
    }
    return why;
}

void remark_iterations(BindReport& report, const std::string& why)
{
    if (!why.empty())
        report.remarks.push_back("solved by iterations on a multigrid in " + in_words(report.factor_bytes) +
                                 ": " + why);
}

} // namespace sinew
