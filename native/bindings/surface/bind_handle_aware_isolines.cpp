// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/handle_aware_isolines.h"

namespace sinew::bindings {

namespace {

void bind_handle_aware_isolines(py::module_& module)
{
    bind_surface_method<HandleAwareIsolines>(
        module, "HandleAwareIsolines",
        R"(As-rigid-as-possible deformation with one rotation per band between isolines [Au et al. 2007].

The bands lie between isolines of the handles' fields, and all vertices of a band share one rotation (tutorial section
6). The points are eliminated by set_handles(), which costs one factorisation, one solve with three columns per band
and four per handle, and 4 bytes per vertex for each of these columns. A frame finds the rotations, which costs nothing
of the size of the mesh, and then takes one product of these columns: the method for few handles on heavy meshes. Where
another shape than the rest shape enters, a frame takes one solve for x, y and z instead.)")
        .def(
            "bands", numbers_of(&HandleAwareIsolines::bands),
            R"(The band of each vertex -> (n,) int32, -1 in a part without a handle; empty before set_handles().

The bands around a handle follow each other, from the handle outwards.)");
}

const MethodBinding handle_aware_isolines_binding(&bind_handle_aware_isolines);

} // namespace

} // namespace sinew::bindings
