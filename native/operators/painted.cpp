// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/painted.h"

#include "native/core/errors.h"
#include "native/core/finite.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace sinew {

std::vector<double> painted(const std::vector<double>& values, int n, double least, const char* name)
{
    const std::string label(name);
    if (values.size() != 1 && static_cast<int>(values.size()) != n)
        throw InvalidOption(label + ": " + std::to_string(values.size()) +
                            " values given; 1 or one per vertex (" + std::to_string(n) + ") needed");
    std::vector<int> bad;
    for (int i = 0; i < static_cast<int>(values.size()); ++i)
        if (!(values[i] >= 0.0 && std::isfinite(values[i])))
            bad.push_back(i);
    if (!bad.empty() && values.size() == 1)
        throw InvalidOption(label + ": " + shortest(values[0]) + " is not a finite number >= 0");
    if (!bad.empty())
        throw InvalidOption(label + ": values at vertices " + list_some(bad) + " are not finite numbers >= 0",
                            Error::Element::vertex, bad);
    const double largest = *std::ranges::max_element(values);
    if (largest == 0.0)
        return {};
    if (values.size() == 1)
        return std::vector<double>(n, largest);
    std::vector<double> raised = values;
    for (double& value : raised)
        value = std::max(value, least * largest);
    return raised;
}

} // namespace sinew
