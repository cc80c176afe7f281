// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/gradient_editing.h"

namespace sinew::bindings {

namespace {

void bind_gradient_editing(py::module_& module)
{
    bind_surface_method<GradientEditing>(
        module, "GradientEditing",
        R"(Gradient-based editing [Yu et al. 2004, Zayer et al. 2005], tutorial sections 4.5.1 and 4.5.3.

The handles turn the gradients of the surface, triangle by triangle: a blend of their linear maps, which fades by a
field (Eq. 16). One Poisson equation (Eq. 15) finds the surface that comes closest to these gradients. set_handles()
costs one factorisation and the fields; a frame is one solve for x, y and z, and one map per triangle. It suits bends
and twists; translations turn nothing.)",
        R"(Raises InvalidOption for another field.)");
}

const MethodBinding gradient_editing_binding(&bind_gradient_editing);

} // namespace

} // namespace sinew::bindings
