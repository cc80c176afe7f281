// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/options.h"

#include <sstream>

namespace sinew::bindings {

std::string documentation(const std::vector<Described>& arguments, const std::string& raises)
{
    constexpr std::size_t line_length = 110;
    std::size_t widest = 0;
    for (const Described& argument : arguments)
        widest = std::max(widest, argument.name.size());
    std::string text = "\n";
    for (const Described& argument : arguments) {
        std::string line = argument.name + std::string(widest + 1 - argument.name.size(), ' ');
        std::istringstream words(argument.text + ".");
        for (std::string word; words >> word; line += ' ' + word)
            if (line.size() + 1 + word.size() > line_length) {
                text += line + '\n';
                line = std::string(widest + 1, ' ');
            }
        text += line + '\n';
    }
    return text + '\n' + raises;
}

} // namespace sinew::bindings
