// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/thin_shell.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

void bind_affine_basis(py::module_& module)
{
    py::class_<AffineBasis>(module, "AffineBasis",
                            "The precomputed response of a ThinShell to affine handle motions [Botsch & "
                            "Kobbelt 2004, section 5].")
        .def(py::init([](const ThinShell& shell) {
                 const AccessLock shared = shell.reading();
                 const Points& rest = shell.rest().points();
                 const Regions& regions = shell.regions();
                 return AffineBasis(rest, shell.respond(AffineBasis::columns(rest, regions)), regions);
             }),
             py::arg("thin_shell"), py::call_guard<py::gil_scoped_release>(),
             "thin_shell  a ThinShell with handles. Cost: one solve of 4k columns.\n\n"
             "Raises InvalidConstraint before its set_handles().")
        .def_property_readonly(
            "matrix", [](const AffineBasis& basis) { return basis.matrix(); },
            "(n, 4k) the responses to x, y, z and 1 on each handle; the responses to 1 sum to 1.")
        .def(
            "solve",
            [](const AffineBasis& basis, const ArrayLike& object) {
                const Poses checked = poses(object);
                return solved([&](Points& positions) { return basis.solve(checked, positions); });
            },
            py::arg("poses"),
            "(k, 3, 4) -> (positions (n, 3), SolveReport), as ThinShell.solve from rest, but free parts "
            "stay.\n"
            "Raises InvalidConstraint for a wrong count, shape or non-finite number.")
        .def("__repr__", [](const AffineBasis& basis) {
            return "<AffineBasis: " + std::to_string(basis.matrix().rows()) + " vertices, " +
                   std::to_string(basis.matrix().cols() / 4) + " handles>";
        });
}

} // namespace sinew::bindings
