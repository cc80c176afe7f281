// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/green.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

GreenOptions green_options(const PointWeightOptions& weights, const std::string& outside, int exit_face,
                           const std::string& faces)
{
    return {weights,
            choose<GreenOutside>(outside, "outside",
                                 {{"nearest", GreenOutside::nearest},
                                  {"face", GreenOutside::face},
                                  {"error", GreenOutside::refuse}}),
            exit_face,
            choose<GreenFaces>(faces, "faces",
                               {{"triangles", GreenFaces::triangles}, {"quads", GreenFaces::quads}})};
}

void bind_green(py::module_& module)
{
    bind_cage_method<Green>(
        module, "Green", R"(Green coordinates [Lipman, Levin & Cohen-Or 2008], section 5.4.

They keep shapes: similarities of the cage are reproduced, shears are not. They have a closed form; the cost
is O(points x triangles). With faces='quads' they are those of Thiery & Boubekeur 2022, to 1e-11.)",
        &green_options,
        R"(outside     for points outside, the map is continued through the 'nearest' triangle or through one
            'face', or an 'error' names them.
exit_face   the face of the cage for outside='face'.
faces       a face with four corners is two 'triangles', or a bilinear patch, which no diagonal cuts: 'quads'.
)",
        py::arg("outside") = "nearest", py::arg("exit_face") = -1, py::arg("faces") = "triangles")
        .def_property_readonly(
            "face_weights", &read<&Green::face_weights, Green>,
            "(n, f) weights of the normals of the triangles that the cage's faces are cut into, "
            "in the unit of length of the cage.\nWith faces='quads', those of other faces, and then three "
            "columns per quad: the integrals of 1, s and t over 4 pi r.");
}

const MethodBinding green_binding(&bind_green);

} // namespace

} // namespace sinew::bindings
