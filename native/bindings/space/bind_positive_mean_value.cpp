// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/positive_mean_value.h"

namespace sinew::bindings {

namespace {

void bind_positive_mean_value(py::module_& module)
{
    bind_cage_method<PositiveMeanValue, PositiveMeanValueOptions>(
        module, "PositiveMeanValue",
        R"(Positive mean value coordinates [Lipman et al. 2007], section 5.4: mean values of what a point sees.

The weights are not negative, sum to 1 and have linear precision; in a convex cage they are mean values. They are
continuous, but their gradients jump where an edge of the cage comes into view.)");
}

const MethodBinding positive_mean_value_binding(&bind_positive_mean_value);

} // namespace

} // namespace sinew::bindings
