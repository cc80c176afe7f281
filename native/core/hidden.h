// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <utility>

namespace sinew {

/// What a class holds of a type that its header only names. How the object is deleted is known where the object was
/// made, so the class needs no destructor and no move of its own.
template <class T>
using Hidden = std::unique_ptr<T, void (*)(T*)>;

template <class T, class... Arguments>
Hidden<T> hidden(Arguments&&... arguments)
{
    return {new T(std::forward<Arguments>(arguments)...), [](T* object) { delete object; }};
}

} // namespace sinew
