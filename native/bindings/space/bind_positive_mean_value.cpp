// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/positive_mean_value.h"

namespace sinew::bindings {

namespace {

PositiveMeanValueOptions positive_mean_value_options(const PointWeightOptions& weights, bool exact,
                                                     int directions, const std::string& outside)
{
    return {weights, exact, directions, cage_outside(outside)};
}

void bind_positive_mean_value(py::module_& module)
{
    bind_cage_method<PositiveMeanValue>(
        module, "PositiveMeanValue",
        R"(Positive mean value coordinates [Lipman et al. 2007], section 5.4: mean values of what a point sees.

The weights are not negative, sum to 1 and have linear precision; in a convex cage they are mean values. They are
continuous, but their gradients jump where an edge of the cage comes into view.)",
        &positive_mean_value_options,
        R"(exact       whether to cut hidden parts away exactly; False takes rays, a preview whose weights jump by
            some 1e-3.
directions  rays per point, an even number of at least 8.
outside     points outside: 'error' names them, 'mean_value' gives them mean value weights.
)",
        py::arg("exact") = true, py::arg("directions") = 1024, py::arg("outside") = "error");
}

const MethodBinding positive_mean_value_binding(&bind_positive_mean_value);

} // namespace

} // namespace sinew::bindings
