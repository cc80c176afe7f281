// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/pyramid_coordinates.h"

#include <vector>

namespace sinew::bindings {

namespace {

void bind_pyramid_coordinates(py::module_& module)
{
    bind_surface_method<PyramidCoordinates>(
        module, "PyramidCoordinates",
        R"(Pyramid coordinates [Sheffer & Kraevoy 2004, Kraevoy & Sheffer 2006], with morphing between two meshes.

Each vertex keeps its place over the ring of its neighbours: the mean-value weights of its projection, its height, and
the ring's edges, up to a rotation or a similarity (tutorial section 6). With a target shape, solve(morph=t) mixes the
coordinates of both meshes; set_handles([]) and solve([], morph=t) do so without handles. set_handles() costs one
factorisation and those of a hierarchy of coarser graphs.)")
        .def(py::init([](const SurfaceMesh& mesh, double side, bool similarity,
                         const SurfaceMesh* target_shape, int max_iterations, double tolerance) {
                 const py::gil_scoped_release unlocked;
                 PyramidCoordinatesOptions options{side, similarity, nullptr, max_iterations, tolerance};
                 if (target_shape)
                     options.target_shape = std::make_shared<const SurfaceMesh>(*target_shape);
                 return std::make_shared<PyramidCoordinates>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("side") = PyramidCoordinatesOptions{}.side,
             py::arg("similarity") = PyramidCoordinatesOptions{}.similarity,
             py::arg("target_shape") = py::none(),
             py::arg("max_iterations") = PyramidCoordinatesOptions{}.max_iterations,
             py::arg("tolerance") = PyramidCoordinatesOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
side            > 0: how firmly rings keep their edges, in comparison with the height of the vertex over them.
similarity      whether rings may also grow and shrink, from half to twice their size.
target_shape    None, or a SurfaceMesh with the same faces, to which solve(morph=t) goes.
max_iterations  largest number of iterations of a solve, >= 1.
tolerance       >= 0: stop when the relative decrease of the energy is below it twice in succession.

Raises InvalidOption; InvalidMesh if the target shape has another number of vertices or other faces, which the error
names.)")
        .def_property_readonly(
            "folded_rings",
            [](const PyramidCoordinates& method) {
                std::vector<int> found;
                {
                    const py::gil_scoped_release unlocked;
                    found = method.folded_rings();
                }
                return to_numpy(found);
            },
            "(f,) vertices whose ring overlaps in its projection, at rest or in the target shape: they have "
            "equal weights.\nNone before set_handles().");
}

const MethodBinding pyramid_coordinates_binding(&bind_pyramid_coordinates);

} // namespace

} // namespace sinew::bindings
