// SPDX-License-Identifier: GPL-3.0-or-later
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
factorisation and those of a hierarchy of coarser graphs.)",
        R"(BindReport.thin_vertices names vertices where the sheet is thinner than the mesh can show, about a quarter of an
edge, and stiffer than asked for.

Raises InvalidOption.)")
        .def("energy", &energy_of<ThinShellNonlinear>, py::arg("positions"),
             R"(Energy of given points over the parts with a handle, with the best rotations -> a number.

positions  (n, 3). The unit is that of an area, times that of k_s.

Raises InvalidConstraint for another shape or a number that is not finite.)");
}

const MethodBinding thin_shell_nonlinear_binding(&bind_thin_shell_nonlinear);

} // namespace

} // namespace sinew::bindings
