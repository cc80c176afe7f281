// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/choices.h"
#include "native/handles/handle_fields.h"

namespace sinew::bindings {

inline Field field_of(const std::string& name)
{
    return choose<Field>(
        name, "field",
        {{"harmonic", Field::harmonic}, {"geodesic", Field::geodesic}, {"euclidean", Field::euclidean}});
}

} // namespace sinew::bindings
