// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/laplacian_editing.h"

namespace sinew::bindings {

namespace {

void bind_laplacian_editing(py::module_& module)
{
    bind_surface_method<LaplacianEditing>(
        module, "LaplacianEditing",
        R"(Laplacian editing [Lipman et al. 2004, Sorkine et al. 2004], tutorial sections 4.5.2 and 4.5.3.

The surface keeps its differential coordinates, each turned by a local transformation: none, a blend of the maps of the
handles, rotations estimated from a first solution, or implicit ones, which are unknowns of a first linear system.
set_handles() costs one factorisation, with harmonic fields two, with implicit transformations about 20; a frame is one
solve for x, y and z, and one more per refit.)",
        R"(Raises InvalidOption for refits < 0, or another name.)");
}

const MethodBinding laplacian_editing_binding(&bind_laplacian_editing);

} // namespace

} // namespace sinew::bindings
