// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

namespace sinew::bindings {

namespace py = pybind11;

/// Adds the class of one method to the module. Each bind_<method>.cpp holds one as a constant, so that
/// module.cpp names no method. It is named after the method, since several of these sources are compiled as
/// one: the names in their unnamed namespaces must differ, too.
class MethodBinding
{
public:
    using Bind = void (*)(py::module_&);

    explicit MethodBinding(Bind bind) noexcept : bind_(bind), next_(first) { first = this; }

    /// Calls every method's `bind`. The classes that methods derive from must be in the module already.
    static void bind_all(py::module_& module)
    {
        for (const MethodBinding* one = first; one; one = one->next_)
            one->bind_(module);
    }

private:
    Bind bind_;
    const MethodBinding* next_;
    inline static const MethodBinding* first = nullptr;
};

} // namespace sinew::bindings
