// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/thin_shell_nonlinear.h"

namespace sinew::bindings {

namespace {

void bind_thin_shell_nonlinear(py::module_& module)
{
    bind_surface_method<ThinShellNonlinear>(
        module, "ThinShellNonlinear",
        R"(Nonlinear thin shell [Terzopoulos et al. 1987]: a sheet that resists stretching and bending.

Minimises 1/2 integral of k_s |I' - I|^2 / 4 + k_b |II' - II|^2 (tutorial Eq. 9) over the deformed points, by
cells of two triangles with a rotation each. p, the incoming shape, is free of strain. set_handles() costs a
factorisation and those of a hierarchy of coarser graphs.)")
        .def(py::init([](const SurfaceMesh& mesh, const std::string& measure, const py::object& thickness,
                         const py::object& stretching, const py::object& bending, int max_iterations,
                         double tolerance) {
                 using Measure = ThinShellNonlinearOptions::Measure;
                 ThinShellNonlinearOptions options;
                 options.measure = choose<Measure>(measure, "measure",
                                                   {{"share", Measure::share},
                                                    {"length", Measure::length},
                                                    {"stiffness", Measure::stiffness}});
                 options.thickness = numbers(thickness, "thickness");
                 options.stretching = numbers(stretching, "stretching");
                 options.bending = numbers(bending, "bending");
                 options.max_iterations = max_iterations;
                 options.tolerance = tolerance;
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<ThinShellNonlinear>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("measure") = "share",
             py::arg("thickness") = ThinShellNonlinearOptions{}.thickness[0],
             py::arg("stretching") = ThinShellNonlinearOptions{}.stretching[0],
             py::arg("bending") = ThinShellNonlinearOptions{}.bending[0],
             py::arg("max_iterations") = ThinShellNonlinearOptions{}.max_iterations,
             py::arg("tolerance") = ThinShellNonlinearOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
measure         'share': thickness is a share of the size of its part (SurfaceMesh.sizes); 'length': a length;
                'stiffness': stretching and bending count instead.
thickness       a number >= 0, or (n,) painted. k_s is 1 and k_b its square.
stretching      k_s, a number > 0, or (n,) painted, >= 0; values below 1e-3 of the largest one are raised to
                that.
bending         k_b, a number >= 0, or (n,) painted: an area times the unit of k_s.
max_iterations  largest number of iterations of a solve, >= 1.
tolerance       >= 0: stop when the relative decrease of the energy is below it twice in succession.

BindReport.thin_vertices names vertices where the sheet is thinner than the mesh can show, about a quarter of an
edge, and stiffer than asked for.

Raises InvalidOption.)")
        .def(
            "energy",
            [](const ThinShellNonlinear& shell, const py::object& object) {
                const FloatArray array = floats(object, "positions");
                const PointsView view = points<InvalidConstraint>(array, "positions");
                const py::gil_scoped_release unlocked;
                return shell.energy(view);
            },
            py::arg("positions"),
            R"(Energy of given points over the parts with a handle, with the best rotations -> a number.

positions  (n, 3). The unit is that of an area, times that of k_s.

Raises InvalidConstraint for another shape or a number that is not finite.)");
}

const MethodBinding thin_shell_nonlinear_binding(&bind_thin_shell_nonlinear);

} // namespace

} // namespace sinew::bindings
