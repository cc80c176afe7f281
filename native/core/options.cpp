// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/options.h"

#include "native/core/errors.h"
#include "native/core/finite.h"

namespace sinew {

bool Range::contains(double value) const
{
    return std::isfinite(value) && (with_least ? value >= least : value > least) &&
           (with_most ? value <= most : value < most);
}

std::string Range::words(bool whole_numbers) const
{
    if (std::isinf(least))
        return "";
    if (std::isinf(most))
        return (with_least ? ">= " : "> ") + shortest(least);
    if (whole_numbers)
        return shortest(least) + " to " + shortest(most);
    return std::string("in ") + (with_least ? "[" : "(") + shortest(least) + ", " + shortest(most) +
           (with_most ? "]" : ")");
}

void require_in_range(double value, const Range& range, const char* name)
{
    if (!range.contains(value)) {
        const std::string words = range.words(false);
        throw InvalidOption(std::string(name) + ": " + shortest(value) + " is not a finite number" +
                            (words.empty() ? "" : " " + words));
    }
}

} // namespace sinew
