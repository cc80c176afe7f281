// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/space/cage/green.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

GreenOptions green_options(const PointWeightOptions& weights, const std::string& outside, int exit_face)
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

They keep shapes: similarities of the cage are reproduced, shears are not. They have a closed form; the cost
is O(points x triangles).)",
        &green_options,
        R"(outside     for points outside, the map is continued through the 'nearest' triangle or through one
            'face', or an 'error' names them.
exit_face   the face of the cage for outside='face'.
)",
        py::arg("outside") = "nearest", py::arg("exit_face") = -1)
        .def_property_readonly(
            "face_weights", &read<&Green::face_weights, Green>,
            "(n, t) weights of the normals of the triangles that the cage's faces are cut into, "
            "in the unit of length of the cage.");
}

const MethodBinding green_binding(&bind_green);

} // namespace

} // namespace sinew::bindings
