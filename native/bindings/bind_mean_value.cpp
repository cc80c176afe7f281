// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/space/cage/mean_value.h"

namespace sinew::bindings {

namespace {

void bind_mean_value(py::module_& module)
{
    bind_cage_method<MeanValue>(
        module, "MeanValue",
        R"(Mean value coordinates [Ju, Schaefer & Warren 2005], section 5.4.

Sum 1 and linear precision everywhere, outside the cage too; may be negative where a concave cage is seen
through itself. A closed form: cost O(points x triangles).)",
        +[](const PointWeightOptions& weights) { return weights; }, "");
}

const MethodBinding binding(&bind_mean_value);

} // namespace

} // namespace sinew::bindings
