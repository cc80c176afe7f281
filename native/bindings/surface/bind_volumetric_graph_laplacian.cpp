// SPDX-License-Identifier: GPL-3.0-or-later
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
one solve for x, y and z.)",
        R"(Raises InvalidOption for another volume or name.)")
        .def(
            "inner_points",
            [](const VolumetricGraphLaplacian& method) { return to_numpy(method.inner_points()); },
            "(g, 3) the points inside at rest, a copy; none before the first set_handles().");
}

const MethodBinding volumetric_graph_laplacian_binding(&bind_volumetric_graph_laplacian);

} // namespace

} // namespace sinew::bindings
