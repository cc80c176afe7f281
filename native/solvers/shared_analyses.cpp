// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/shared_analyses.h"

#include <utility>

namespace sinew {

thread_local SharedAnalyses* SharedAnalyses::current = nullptr;

std::shared_ptr<const Analysis> SharedAnalyses::find(const Key& key)
{
    if (!current)
        return nullptr;
    const auto at = current->kept_.find(key);
    return at == current->kept_.end() ? nullptr : at->second;
}

void SharedAnalyses::keep(const Key& key, std::shared_ptr<const Analysis> analysis)
{
    if (current && analysis)
        current->kept_.insert_or_assign(key, std::move(analysis));
}

} // namespace sinew
