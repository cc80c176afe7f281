// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/surface/linear/thin_shell.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

void bind_affine_basis(py::module_& module)
{
    py::class_<AffineBasis>(
        module, "AffineBasis",
        "Precomputed answer of a ThinShell to affine handle motion [Botsch & Kobbelt 2004, section 5].")
        .def(py::init([](const ThinShell& shell) {
                 const Points& rest = shell.rest().points();
                 return AffineBasis(rest, shell.respond(AffineBasis::columns(rest, shell.regions())));
             }),
             py::arg("thin_shell"), py::call_guard<py::gil_scoped_release>(),
             "thin_shell  with its handles set. Cost: 4k solves together, once.")
        .def_property_readonly(
            "matrix", [](const AffineBasis& basis) { return basis.matrix(); },
            "(n, 4k) answers to x, y, z and 1 on each handle; the ones sum to 1.")
        .def(
            "solve",
            [](const AffineBasis& basis, const py::object& object) {
                const Poses checked = poses(object);
                return solved([&](Points& positions) { return basis.solve(checked, positions); });
            },
            py::arg("poses"),
            "(k, 3, 4) -> (positions (n, 3), SolveReport), as ThinShell.solve from rest.\n"
            "Raises InvalidConstraint for a wrong count, shape or non-finite number.");
}

} // namespace sinew::bindings
