// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/thin_shell.h"

namespace sinew::bindings {

namespace {

void bind_thin_shell(py::module_& module)
{
    bind_surface_method<ThinShell>(module, "ThinShell",
                                   R"(Linear thin shell [Botsch & Kobbelt 2004], tutorial section 4.3.

The displacement d satisfies -k_s Delta d + k_b Delta^2 d - k_v Delta^3 d = 0 on free vertices (Eq. 12).
set_handles() costs one factorisation; if it only adds a few vertices to the last handles, the part of the
factor that depends on these. A frame is one small matrix product for up to 16 handles moved from rest,
otherwise one solve for x, y and z. It suits translations and gentle bends; details do not rotate with the
surface.)",
                                   R"(Raises InvalidOption for negative, NaN or all-zero stiffnesses.)")
        .def(
            "set_stiffness",
            [](ThinShell& shell, const ArrayLike& stretching, const ArrayLike& bending,
               const ArrayLike& variation, const Callback& callback) {
                const auto s = numbers(stretching, "stretching");
                const auto b = numbers(bending, "bending");
                const auto v = numbers(variation, "variation");
                const Progress ticks = progress(callback);
                const py::gil_scoped_release unlocked;
                return shell.set_stiffness(s, b, v, ticks);
            },
            py::arg("stretching"), py::arg("bending"), py::arg("variation") = 0.0,
            py::arg("progress") = py::none(),
            R"(Change the stiffnesses and keep the handles -> BindReport.

stretching, bending, variation  k_s, k_b, k_v as in the constructor: a number >= 0, or (n,) painted.
progress                        None or callable(fraction, stage); returning False cancels.

Cost: a numeric factorisation; after a change on a few vertices, of the part that depends on these.
Raises InvalidOption, FactorizationFailed or Cancelled; the object then stays as it was.)");
}

const MethodBinding thin_shell_binding(&bind_thin_shell);

} // namespace

} // namespace sinew::bindings
