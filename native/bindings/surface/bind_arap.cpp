// SPDX-License-Identifier: GPL-3.0-or-later
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
        .def("energy", &energy_of<Arap>, py::arg("positions"),
             R"(Energy of given points over the parts with a handle, with fitted rotations -> a number.

positions  (n, 3). The unit is that of sum w |edge|^2: the square of a length.

Raises InvalidConstraint for another shape or a number that is not finite.)");
}

const MethodBinding arap_binding(&bind_arap);

} // namespace

} // namespace sinew::bindings
