// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/choices.h"
#include "native/operators/laplacian.h"

namespace sinew::bindings {

inline Discretization discretization(const std::string& name)
{
    return choose<Discretization>(name, "laplacian",
                                  {{"uniform", Discretization::uniform},
                                   {"cotan", Discretization::cotan},
                                   {"cotan_voronoi", Discretization::cotan_voronoi}});
}

} // namespace sinew::bindings
