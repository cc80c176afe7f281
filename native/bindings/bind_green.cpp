// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/space/cage/green.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

GreenOptions options(const PointWeightOptions& weights, const std::string& outside, int exit_face)
{
    return {weights,
            choose<GreenOutside>(outside, "outside",
                                 {{"nearest", GreenOutside::nearest},
                                  {"face", GreenOutside::face},
                                  {"error", GreenOutside::refuse}}),
            exit_face};
}

void bind_green(py::module_& module)
{
    bind_cage_method<Green>(
        module, "Green", R"(Green coordinates [Lipman, Levin & Cohen-Or 2008], section 5.4.

Shapes are kept: similarities of the cage are reproduced, shears are not. A closed form: cost
O(points x triangles).)",
        &options,
        R"(outside     what becomes of points outside: continued through the 'nearest' triangle, through one
            'face', or an 'error' that names them.
exit_face   of the cage, for outside='face'.
)",
        py::arg("outside") = "nearest", py::arg("exit_face") = -1)
        .def_property_readonly(
            "face_weights", &Green::face_weights,
            "(n, t) weights of the normals of the triangles that the cage's faces are cut into, "
            "in the cage's units of length.");
}

const MethodBinding binding(&bind_green);

} // namespace

} // namespace sinew::bindings
