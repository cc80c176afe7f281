// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

Error::Error(const std::string& message, Element kind, std::vector<int> elements)
    : std::runtime_error(message), kind_(kind), elements_(std::move(elements))
{
}

void require_at_least(double value, double least, const char* name)
{
    if (!(value >= least && std::isfinite(value)))
        throw InvalidOption(std::string(name) + ": " + std::to_string(value) +
                            " is not a finite number >= " + std::to_string(least));
}

std::string list_some(const std::vector<int>& elements, std::size_t most)
{
    std::string text;
    const std::size_t shown = std::min(elements.size(), most);
    for (std::size_t i = 0; i < shown; ++i)
        text += (i ? ", " : "") + std::to_string(elements[i]);
    if (elements.size() > shown)
        text += " and " + std::to_string(elements.size() - shown) + " more";
    return text;
}

} // namespace sinew
