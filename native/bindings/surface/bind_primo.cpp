// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/primo.h"

namespace sinew::bindings {

namespace {

void bind_primo(py::module_& module)
{
    bind_surface_method<Primo>(
        module, "Primo",
        R"(Rigid prisms on the faces, coupled at the edges [Botsch, Pauly, Gross & Kobbelt 2006].

Minimises sum |e|^2 / (A_i + A_j) int int |d(s, t)|^2 ds dt over the pairs of faces that share an edge e, where
d is how far the sides of their prisms come apart (tutorial section 6). A vertex goes to the mean of where the
prisms around it take it. The prisms stand on the incoming shape. set_handles() costs two factorisations and
those of a hierarchy of coarser graphs. The energy of a report is that of the prisms and of soft handles.)")
        .def(py::init(
                 [](const SurfaceMesh& mesh, const py::object& height, int max_iterations, double tolerance) {
                     PrimoOptions options;
                     options.height = numbers(height, "height");
                     options.max_iterations = max_iterations;
                     options.tolerance = tolerance;
                     const py::gil_scoped_release unlocked;
                     return std::make_shared<Primo>(mesh, options);
                 }),
             py::arg("mesh"), py::kw_only(), py::arg("height") = PrimoOptions{}.height.front(),
             py::arg("max_iterations") = PrimoOptions{}.max_iterations,
             py::arg("tolerance") = PrimoOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
height          how far the prisms reach above and below the surface, as a share of the size of their part
                (SurfaceMesh.sizes): a number > 0, or (n,) painted, >= 0; values below 1e-3 of the largest one are
                raised to that. Higher prisms resist bending and twisting more.
max_iterations  largest number of iterations of a solve, >= 1.
tolerance       >= 0: stop when the relative decrease of the energy is below it twice in succession.

Raises InvalidOption.)");
}

const MethodBinding primo_binding(&bind_primo);

} // namespace

} // namespace sinew::bindings
