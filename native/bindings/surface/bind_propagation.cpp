// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/field.h"
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
With t(s) = s, an affine map of all handles together is reproduced.)")
        .def(py::init([](const SurfaceMesh& mesh, const std::string& field, const py::object& transfer) {
                 PropagationOptions options{.field = field_of(field)};
                 if (!transfer.is_none())
                     options.transfer = numbers(transfer, "transfer");
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<Propagation>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("field") = "harmonic", py::arg("transfer") = py::none(),
             R"(
mesh      SurfaceMesh, the rest shape.
field     s: 'harmonic' (Eq. 8), or by distances: 'geodesic' along the surface, 'euclidean' in a straight line.
transfer  (k,) values of t(s) at even steps from s = 0 to s = 1, k >= 2; None for t(s) = s.

Raises InvalidOption for another field, or values that are too few or not finite.)");
}

const MethodBinding propagation_binding(&bind_propagation);

} // namespace

} // namespace sinew::bindings
