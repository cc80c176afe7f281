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

std::string in_a_row(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? "" : ", ") + name;
    return text;
}

} // namespace sinew
