// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_points.h"
#include "native/methods/space/points/space_propagation.h"

namespace sinew::bindings {

namespace {

void bind_space_propagation(py::module_& module)
{
    bind_points_method<SpacePropagation>(
        module, "SpacePropagation",
        R"(Transformation propagation in space [Pauly et al. 2003], section 5.2.

The rotation, the scale and the move of each handle fade with the straight distance from it, for any points. With
t(s) = s, an affine map of all handles together is reproduced.)")
        .def(
            py::init([](const py::object& points, const py::object& counts, const py::object& weights,
                        const py::object& transfer) {
                HandlePoints handles = handle_points(points, counts, weights);
                SpacePropagationOptions options;
                if (!transfer.is_none())
                    options.transfer = numbers(transfer, "transfer");
                const py::gil_scoped_release unlocked;
                return std::make_shared<SpacePropagation>(std::move(handles), options);
            }),
            py::arg("points"), py::arg("counts") = py::none(), py::kw_only(), py::arg("weights") = py::none(),
            py::arg("transfer") = py::none(),
            with_handle_points(
                R"(transfer   (k,) values of t(s) at even steps from s = 0 to s = 1, k >= 2; None for t(s) = s.

Raises InvalidConstraint for points that are not finite or none, or counts that do not fit; InvalidOption.)")
                .c_str());
}

const MethodBinding space_propagation_binding(&bind_space_propagation);

} // namespace

} // namespace sinew::bindings
