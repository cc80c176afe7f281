// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/green.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

void bind_green(py::module_& module)
{
    bind_cage_method<Green, GreenOptions>(module, "Green",
                                          R"(Green coordinates [Lipman, Levin & Cohen-Or 2008], section 5.4.

They keep shapes: similarities of the cage are reproduced, shears are not. They have a closed form; the cost
is O(points x triangles). With faces='quads' they are those of Thiery & Boubekeur 2022, to 1e-11.)")
        .def_property_readonly(
            "face_weights", &read<&Green::face_weights, Green>,
            "(n, f) weights of the normals of the triangles that the cage's faces are cut into, "
            "in the unit of length of the cage.\nWith faces='quads', those of other faces, and then three "
            "columns per quad: the integrals of 1, s and t over 4 pi r.");
}

const MethodBinding green_binding(&bind_green);

} // namespace

} // namespace sinew::bindings
