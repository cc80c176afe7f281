// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/discretization.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/volumetric_graph_laplacian.h"

namespace sinew::bindings {

namespace {

void bind_volumetric_graph_laplacian(py::module_& module)
{
    bind_surface_method<VolumetricGraphLaplacian>(
        module, "VolumetricGraphLaplacian",
        R"(Laplacian editing with a graph inside the volume [Zhou et al. 2005], tutorial section 4.5.2.

A shell of points beneath the surface and a lattice inside hold its sides apart. Details turn as the handles do, and the
turn fades over surface and volume. set_handles() costs two factorisations and, the first time, makes the graph; a frame is
one solve for x, y and z.)")
        .def(py::init([](const SurfaceMesh& mesh, double volume, const std::string& laplacian) {
                 const VolumetricGraphLaplacianOptions options{volume, discretization(laplacian)};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<VolumetricGraphLaplacian>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("volume") = 1.0, py::arg("laplacian") = "cotan_voronoi",
             R"(
mesh       SurfaceMesh, the rest shape. Inside is where its faces wind around more than half.
volume     >= 0, how much the graph counts beside the surface; 0 leaves the surface alone.
laplacian  'uniform', 'cotan' or 'cotan_voronoi' (section 3.2), of the surface.

Raises InvalidOption for another volume or name.)")
        .def(
            "inner_points",
            [](const VolumetricGraphLaplacian& method) { return to_numpy(method.inner_points()); },
            "(g, 3) the points inside at rest, a copy; none before the first set_handles().");
}

const MethodBinding volumetric_graph_laplacian_binding(&bind_volumetric_graph_laplacian);

} // namespace

} // namespace sinew::bindings
