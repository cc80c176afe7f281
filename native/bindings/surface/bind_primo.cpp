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
those of a hierarchy of coarser graphs. The energy of a report is that of the prisms and of soft handles.)");
}

const MethodBinding primo_binding(&bind_primo);

} // namespace

} // namespace sinew::bindings
