// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_points.h"
#include "native/methods/space/nonlinear/mls.h"

#include <array>
#include <string>
#include <vector>

namespace sinew::bindings {

namespace {

void bind_mls(py::module_& module)
{
    bind_points_method<Mls, MlsOptions>(
        module, "Mls",
        R"(Moving least squares [Schaefer, McPhail & Warren 2006, Zhu & Gortler 2007], section 7.

At each point, the map that fits the handles best, near ones the more. A point on a handle goes where the handle takes
it. bind() computes the weights of all handles at each point; a frame fits one map per point.)",
        R"(Raises InvalidConstraint for points that are not finite or none, counts that do not fit, or a segment without length;
InvalidOption.)")
        .def_property_readonly(
            "maps", [](const Mls& method) { return name_of(method.maps()); },
            "The maps that are fitted: 'affine', 'similarity' or 'rigid'.");
}

const MethodBinding mls_binding(&bind_mls);

} // namespace

} // namespace sinew::bindings
