// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"

#include <initializer_list>
#include <string>
#include <utility>

namespace sinew::bindings {

/// The enumerator that belongs to a name.
/// \throw InvalidOption  an unknown name; the message lists the known ones.
template <class T>
T choose(const std::string& value, const char* name, std::initializer_list<std::pair<const char*, T>> choices)
{
    std::string known;
    for (const auto& [key, result] : choices) {
        if (value == key)
            return result;
        known += (known.empty() ? "'" : ", '") + std::string(key) + "'";
    }
    throw InvalidOption(std::string(name) + ": '" + value + "' is not one of " + known);
}

} // namespace sinew::bindings
