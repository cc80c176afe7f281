// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/engines/factor_engine.h"
#include "native/solvers/spd_factor.h"

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>

namespace sinew {

/// While one of these lives, all factors that its thread makes of matrices with the same pattern share the
/// elimination order and the symbolic factorisation. For a method that holds another one on the same surface:
/// for a bi-Laplacian, these are a third of a bind. The factors have the same bits as without it.
class SharedAnalyses
{
public:
    SharedAnalyses() : outer_(current) { current = this; }
    ~SharedAnalyses() { current = outer_; }
    SharedAnalyses(const SharedAnalyses&) = delete;
    SharedAnalyses& operator=(const SharedAnalyses&) = delete;

    /// What the analysis depends on: the digest of the pattern, the number of unknowns, and the options.
    using Key = std::tuple<std::uint64_t, int, FactorBackend, Ordering>;

    /// Null where nobody has kept it.
    static std::shared_ptr<const Analysis> find(const Key& key);
    static void keep(const Key& key, std::shared_ptr<const Analysis> analysis);

private:
    static thread_local SharedAnalyses* current;

    SharedAnalyses* outer_;
    std::map<Key, std::shared_ptr<const Analysis>> kept_;
};

} // namespace sinew
