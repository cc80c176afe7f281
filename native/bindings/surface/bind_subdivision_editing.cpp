// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/subdivision_editing.h"

namespace sinew::bindings {

namespace {

void bind_subdivision_editing(py::module_& module)
{
    bind_surface_method<SubdivisionEditing>(
        module, "SubdivisionEditing",
        R"(Subdivision editing [Zorin, Schröder & Sweldens 1997], tutorial section 4.3.

For meshes that come from subdividing a coarse one, by Catmull-Clark's or Loop's rules, and were sculpted then. The bind
undoes the levels; the handles move the control mesh as a thin plate, and what was sculpted on each finer level rides on
it in frames of the limit surface. Parts that do not come from subdivision move as a thin plate on the mesh itself;
BindReport.irregular_parts counts them. set_handles() costs a factorisation per level below the finest, and one around
the handles; a frame is O(n) and a solve around the handles. Rigid motions of all handles are reproduced.)",
        R"(Raises InvalidOption for levels < 0, or another name.)")
        .def("level_counts", &SubdivisionEditing::level_counts,
             "How often the last bind coarsened each part; parts are numbered by their lowest vertices.")
        .def("control_mesh", &SubdivisionEditing::control_mesh,
             "The control mesh of the last bind, of all parts together; before it, the rest shape.");
}

const MethodBinding subdivision_editing_binding(&bind_subdivision_editing);

} // namespace

} // namespace sinew::bindings
