// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/rotation_invariant_coordinates.h"

namespace sinew::bindings {

namespace {

void bind_rotation_invariant_coordinates(py::module_& module)
{
    bind_surface_method<RotationInvariantCoordinates>(
        module, "RotationInvariantCoordinates",
        R"(Rotation-invariant coordinates [Lipman et al. 2005, 2007], tutorial section 4.5.3.

Local frames keep their rotations to their neighbours as well as they can, which makes them harmonic between the
rotations of the handles; then edges keep their coordinates in these frames as well as they can. set_handles() costs
one factorisation, which serves both, and the fields of the handles; a frame is one solve for x, y and z, and one
rotation fit per vertex. It suits bends and twists of less than half a turn; translations turn nothing.)",
        R"(Raises InvalidOption for another one.)");
}

const MethodBinding rotation_invariant_coordinates_binding(&bind_rotation_invariant_coordinates);

} // namespace

} // namespace sinew::bindings
