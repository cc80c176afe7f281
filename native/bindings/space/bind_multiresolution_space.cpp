// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/handle_points.h"
#include "native/methods/multiresolution/multiresolution_space.h"

#include <string>

namespace sinew::bindings {

namespace {

void bind_multiresolution_space(py::module_& module)
{
    bind_points_method<MultiresolutionSpace>(
        module, "MultiresolutionSpace",
        R"(Multiresolution deformation in space [Marinov, Botsch & Kobbelt 2007], sections 4.4 and 5.3.

A space method on handle points moves a smooth base of a mesh, and the details are put back on it: they turn with the
base where it bends. Vertices at handle points have no details, so handles are met as the space method meets them.)")
        .def(py::init([](const py::object& points, const std::shared_ptr<SpaceMethod>& base,
                         const SurfaceMesh& mesh, const py::object& counts, const py::object& weights,
                         const std::string& details, double wavelength, int bands) {
                 HandlePoints handles = handle_points(points, counts, weights);
                 const MultiresolutionOptions options{
                     choose<DetailKind>(details, "details",
                                        {{"displacement_vectors", DetailKind::displacement_vectors},
                                         {"normal_displacements", DetailKind::normal_displacements},
                                         {"displacement_volumes", DetailKind::displacement_volumes},
                                         {"deformation_transfer", DetailKind::deformation_transfer}}),
                     wavelength, bands};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<MultiresolutionSpace>(std::move(handles), base, mesh, options);
             }),
             py::arg("points"), py::arg("base").none(false), py::arg("mesh"), py::arg("counts") = py::none(),
             py::kw_only(), py::arg("weights") = py::none(), py::arg("details") = "displacement_vectors",
             py::arg("wavelength") = 10.0, py::arg("bands") = 1,
             with_handle_points(
                 R"(base       SpaceMethod on the same handles. It belongs to this object from now on.
mesh       SurfaceMesh, the rest shape; all of its vertices can be bound, or some.
details    how the details are stored: 'displacement_vectors', 'normal_displacements', 'displacement_volumes' or
           'deformation_transfer', as in Multiresolution.
wavelength > 0, in mean edge lengths: waves that are shorter are details.
bands      1 to 8; each further band takes the details of twice the wavelength off what the one before left.

Raises InvalidConstraint for points that are not finite or none, or counts that do not fit; InvalidOption.)")
                 .c_str());
}

const MethodBinding multiresolution_space_binding(&bind_multiresolution_space);

} // namespace

} // namespace sinew::bindings
