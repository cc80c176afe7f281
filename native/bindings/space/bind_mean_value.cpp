// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/mean_value.h"

namespace sinew::bindings {

namespace {

/// Beside those of the weights, the method has none.
struct MeanValueOptions
{
    PointWeightOptions weights;

    operator const PointWeightOptions&() const { return weights; }
    static constexpr auto table() { return std::tuple{}; }
};

void bind_mean_value(py::module_& module)
{
    bind_cage_method<MeanValue, MeanValueOptions>(
        module, "MeanValue",
        R"(Mean value coordinates [Ju, Schaefer & Warren 2005], section 5.4.

The weights sum to 1 and have linear precision everywhere, also outside the cage. They may be negative where, seen
from a point, one part of a concave cage hides another. They have a closed form; the cost is
O(points x triangles).)");
}

const MethodBinding mean_value_binding(&bind_mean_value);

} // namespace

} // namespace sinew::bindings
