// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/field.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/handle_aware_isolines.h"

namespace sinew::bindings {

namespace {

void bind_handle_aware_isolines(py::module_& module)
{
    bind_surface_method<HandleAwareIsolines>(
        module, "HandleAwareIsolines",
        R"(As-rigid-as-possible deformation with one rotation per band between isolines [Au et al. 2007].

The bands lie between isolines of the handles' fields, and all vertices of a band share one rotation (tutorial section
6). The points are eliminated by set_handles(), which costs one factorisation, one solve with three columns per band
and four per handle, and 4 bytes per vertex for each of these columns. A frame finds the rotations, which costs nothing
of the size of the mesh, and then takes one product of these columns: the method for few handles on heavy meshes. Where
another shape than the rest shape enters, a frame takes one solve for x, y and z instead.)")
        .def(py::init([](const SurfaceMesh& mesh, int bands, const std::string& field, int max_iterations,
                         double tolerance) {
                 const HandleAwareIsolinesOptions options{.bands = bands,
                                                          .field = field_of(field),
                                                          .max_iterations = max_iterations,
                                                          .tolerance = tolerance};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<HandleAwareIsolines>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("bands") = HandleAwareIsolinesOptions{}.bands,
             py::arg("field") = "harmonic",
             py::arg("max_iterations") = HandleAwareIsolinesOptions{}.max_iterations,
             py::arg("tolerance") = HandleAwareIsolinesOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
bands           bands between two handles, >= 2; each handle has half of them around it.
field           whose isolines bound the bands: 'harmonic', 'geodesic' or 'euclidean'.
max_iterations  largest number of turns of a solve, >= 1; each fits the rotations of all bands once.
tolerance       >= 0: stop when the matrix of no rotation changes by more.

Raises InvalidOption.)")
        .def(
            "bands",
            [](const HandleAwareIsolines& method) {
                std::vector<int> bands;
                {
                    const py::gil_scoped_release unlocked;
                    bands = method.bands();
                }
                return to_numpy(bands);
            },
            R"(The band of each vertex -> (n,) int32, -1 in a part without a handle; empty before set_handles().

The bands around a handle follow each other, from the handle outwards.)");
}

const MethodBinding handle_aware_isolines_binding(&bind_handle_aware_isolines);

} // namespace

} // namespace sinew::bindings
