// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arap_options.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/arap.h"

namespace sinew::bindings {

namespace {

void bind_arap(py::module_& module)
{
    bind_surface_method<Arap>(
        module, "Arap",
        R"(As-rigid-as-possible [Sorkine & Alexa 2007] with smooth rotations [Levi & Gotsman 2015].

Minimises sum_i r_i sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2 + alpha A sum_ij r_ij w_ij |R_i - R_j|^2
over points q and rotations R, for ordered pairs of neighbours (tutorial section 6). Details rotate with the
surface. p is the incoming shape. set_handles() costs two factorisations and those of a hierarchy of coarser
graphs.)")
        .def(py::init([](const SurfaceMesh& mesh, double smoothness, const std::string& cells,
                         const py::object& rigidity, int max_iterations, double tolerance,
                         double point_handles) {
                 const ArapOptions options =
                     arap_options(smoothness, cells, rigidity, max_iterations, tolerance, point_handles);
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<Arap>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("smoothness") = ArapOptions{}.smoothness,
             py::arg("cells") = "spokes", py::arg("rigidity") = 1.0,
             py::arg("max_iterations") = ArapOptions{}.max_iterations,
             py::arg("tolerance") = ArapOptions{}.tolerance,
             py::arg("point_handles") = ArapOptions{}.point_handles, R"(
mesh            SurfaceMesh, the rest shape.
smoothness      alpha >= 0: how smooth the rotations are; 0 gives the energy of Sorkine and Alexa, which
                buckles on dense meshes.
cells           'spokes' [SA07] or 'rims' (spokes and rims).
rigidity        how stiff each vertex's cell is: a number > 0, or (n,) painted, >= 0; values below 1e-3 of
                the largest one are raised to that.
max_iterations  largest number of iterations of a solve, >= 1.
tolerance       >= 0: stop when the relative decrease of the energy is below it twice in succession.
point_handles   lambda in [0, 1): how smooth the surface is also at handles of a single vertex [Oehri, Herholz &
                Sorkine-Hornung 2025]; with 'spokes' only. The energy of a report is then
                (1 - lambda) E + 2 lambda sum |r_i|^2 / m_i with r the gradient of E / 4 at all vertices and
                masses m whose mean is 1.

Raises InvalidOption.)")
        .def(
            "energy",
            [](const Arap& arap, const py::object& object) {
                const FloatArray array = floats(object, "positions");
                const PointsView view = points<InvalidConstraint>(array, "positions");
                const py::gil_scoped_release unlocked;
                return arap.energy(view);
            },
            py::arg("positions"),
            R"(Energy of given points over the parts with a handle, with fitted rotations -> a number.

positions  (n, 3). The unit is that of sum w |edge|^2: the square of a length.

Raises InvalidConstraint for another shape or a number that is not finite.)");
}

const MethodBinding arap_binding(&bind_arap);

} // namespace

} // namespace sinew::bindings
