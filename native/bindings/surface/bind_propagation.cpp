// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/propagation.h"

namespace sinew::bindings {

namespace {

void bind_propagation(py::module_& module)
{
    bind_surface_method<Propagation>(
        module, "Propagation",
        R"(Transformation propagation [Bendels & Klein 2003, Pauly et al. 2003], tutorial section 4.2.

The rotation, the scale and the move of each handle fade over the surface by its field s, each about the centre of the
handle, and held vertices go where their handle takes them. set_handles() costs the fields; a frame has no equations.
With t(s) = s, an affine map of all handles together is reproduced.)",
        R"(Raises InvalidOption for another field, or values that are too few or not finite.)");
}

const MethodBinding propagation_binding(&bind_propagation);

} // namespace

} // namespace sinew::bindings
