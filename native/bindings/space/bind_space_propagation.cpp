// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_points.h"
#include "native/methods/space/points/space_propagation.h"

namespace sinew::bindings {

namespace {

void bind_space_propagation(py::module_& module)
{
    bind_points_method<SpacePropagation, SpacePropagationOptions>(
        module, "SpacePropagation",
        R"(Transformation propagation in space [Pauly et al. 2003], section 5.2.

The rotation, the scale and the move of each handle fade with the straight distance from it, for any points. With
t(s) = s, an affine map of all handles together is reproduced.)");
}

const MethodBinding space_propagation_binding(&bind_space_propagation);

} // namespace

} // namespace sinew::bindings
