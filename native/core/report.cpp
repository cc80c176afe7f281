// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/report.h"

namespace sinew {

std::vector<std::string> names_of(std::initializer_list<Difference> differences,
                                  std::vector<std::string> names)
{
    for (const auto& [name, differs] : differences)
        if (differs)
            names.emplace_back(name);
    return names;
}

std::string joined(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::string summary_of(std::initializer_list<Count> counts)
{
    std::vector<std::string> parts;
    for (const auto& [number, one, several] : counts)
        if (number > 0)
            parts.push_back(std::to_string(number) + " " + (number == 1 ? one : several));
    return parts.empty() ? "clean" : joined(parts);
}

} // namespace sinew
