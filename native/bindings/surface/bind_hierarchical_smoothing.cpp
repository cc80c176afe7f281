// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/hierarchical_smoothing.h"

namespace sinew::bindings {

namespace {

void bind_hierarchical_smoothing(py::module_& module)
{
    bind_surface_method<HierarchicalSmoothing>(
        module, "HierarchicalSmoothing",
        R"(Hierarchical smoothing [Guskov, Sweldens & Schröder 1999], tutorial section 4.3.

The handles move a coarse mesh, which gets its vertices back level by level. Each level is relaxed by second
differences over pairs of triangles, and its details ride on it in local frames. Planar regions are exact.
set_handles() costs the hierarchy, O(n log n), and a small factorisation; a frame is a few sweeps over all levels,
which together have about six times the vertices of the mesh. Rigid motions of all handles are reproduced.)",
        R"(Raises InvalidOption for a number below 0.)");
}

const MethodBinding hierarchical_smoothing_binding(&bind_hierarchical_smoothing);

} // namespace

} // namespace sinew::bindings
