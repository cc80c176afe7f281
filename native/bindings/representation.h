// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace sinew::bindings {

/// "<Arap: 121 vertices>": the name of the object's own class, which may be derived, and what it holds.
inline std::string representation(const pybind11::object& self, const std::string& contents)
{
    return "<" + std::string(pybind11::str(pybind11::type::of(self).attr("__name__"))) + ": " + contents +
           ">";
}

} // namespace sinew::bindings
