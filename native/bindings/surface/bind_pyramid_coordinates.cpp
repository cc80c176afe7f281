// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/pyramid_coordinates.h"

#include <vector>

namespace sinew::bindings {

namespace {

void bind_pyramid_coordinates(py::module_& module)
{
    bind_surface_method<PyramidCoordinates>(
        module, "PyramidCoordinates",
        R"(Pyramid coordinates [Sheffer & Kraevoy 2004, Kraevoy & Sheffer 2006], with morphing between two meshes.

Each vertex keeps its place over the ring of its neighbours: the mean-value weights of its projection, its height, and
the ring's edges, up to a rotation or a similarity (tutorial section 6). With a target shape, solve(morph=t) mixes the
coordinates of both meshes; set_handles([]) and solve([], morph=t) do so without handles. set_handles() costs one
factorisation and those of a hierarchy of coarser graphs.)",
        R"(Raises InvalidOption; InvalidMesh if the target shape has another number of vertices or other faces, which the error
names.)")
        .def_property_readonly(
            "folded_rings", numbers_of(&PyramidCoordinates::folded_rings),
            "(f,) vertices whose ring overlaps in its projection, at rest or in the target shape: they have "
            "equal weights.\nNone before set_handles().");
}

const MethodBinding pyramid_coordinates_binding(&bind_pyramid_coordinates);

} // namespace

} // namespace sinew::bindings
