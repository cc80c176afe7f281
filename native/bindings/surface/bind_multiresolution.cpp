// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/surface.h"
#include "native/methods/multiresolution/multiresolution.h"

#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

void bind_multiresolution(py::module_& module)
{
    bind_surface_method<Multiresolution>(
        module, "Multiresolution",
        R"(Multiresolution deformation [Kobbelt et al. 1998, Botsch et al. 2008], tutorial section 4.4.

Another method moves a smooth base of the surface, and the details are put back on it: they turn with the base where it
bends or twists, also if that method turns none itself, as the thin shell. set_handles() binds the base method and costs
one factorisation more per band; a frame is one of the base method, mostly for an incoming shape, and the details.
Handles and open borders have no details, so handles are met exactly.)")
        .def(py::init([](const SurfaceMesh& mesh, const std::shared_ptr<SurfaceMethod>& base,
                         const std::string& details, double wavelength, int bands) {
                 const MultiresolutionOptions options{
                     choose<DetailKind>(details, "details",
                                        {{"displacement_vectors", DetailKind::displacement_vectors},
                                         {"normal_displacements", DetailKind::normal_displacements},
                                         {"displacement_volumes", DetailKind::displacement_volumes},
                                         {"deformation_transfer", DetailKind::deformation_transfer}}),
                     wavelength, bands};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<Multiresolution>(mesh, base, options);
             }),
             py::arg("mesh"), py::arg("base").none(false), py::kw_only(),
             py::arg("details") = "displacement_vectors", py::arg("wavelength") = 10.0, py::arg("bands") = 1,
             R"(
mesh        SurfaceMesh, the rest shape.
base        SurfaceMethod on the same mesh, which moves the smooth shape. It belongs to this object from now on.
details     how the details are stored: 'displacement_vectors' that turn with the base (section 4.4.1),
            'normal_displacements', heights above it (4.4.2), 'displacement_volumes' between it and the surface
            (4.4.3), or 'deformation_transfer': not at all, as its faces are mapped like those of the base (4.4.4).
wavelength  > 0, in mean edge lengths: waves that are shorter are details.
bands       1 to 8; each further band takes the details of twice the wavelength off what the one before left.

Raises InvalidOption for a base on another mesh, or for an option out of its range.)")
        .def(
            "levels",
            [](const Multiresolution& method) {
                std::vector<Points> levels;
                {
                    const py::gil_scoped_release unlocked;
                    levels = method.levels();
                }
                py::list found;
                for (Points& level : levels)
                    found.append(to_numpy(std::move(level)));
                return found;
            },
            "[(n, 3)] the rest shape and what each band left of it, bands + 1 shapes; the rest shape alone "
            "before\n"
            "set_handles().");
}

const MethodBinding multiresolution_binding(&bind_multiresolution);

} // namespace

} // namespace sinew::bindings
