// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/spline_surface.h"

#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

py::list control_grids(const SplineSurface& surface, const ArrayLike& poses, const OptionalArray& incoming,
                       const OptionalFlags& from_rest, const OptionalArray& grid)
{
    Poses maps = bindings::poses(poses);
    std::optional<std::vector<bool>> aims = flags(from_rest, maps.size());
    const OptionalPoints entering(incoming, "incoming"), moves(grid, "grid");
    SolveRequest request{.poses = std::move(maps), .incoming = entering.view, .from_rest = std::move(aims)};
    if (moves.view)
        request.extra.emplace<GridMoves>(*moves.view);
    std::vector<SplineSurface::Grid> grids;
    {
        const py::gil_scoped_release unlocked;
        grids = surface.control_grids(request);
    }
    py::list found;
    for (SplineSurface::Grid& grid : grids)
        found.append(to_numpy(std::move(grid.points)).reshape({grid.rows, grid.columns, 3}));
    return found;
}

void bind_spline_surface(py::module_& module)
{
    bind_surface_method<SplineSurface>(
        module, "SplineSurface",
        R"(Spline surface [Farin 1997], tutorial sections 2.1 and 4.1.

A tensor-product B-spline over a UV map or a fitted plane displaces the surface, and the handles move its control grid:
by least squares where they ask for more than it can do, and else with the least change of the grid. What the spline
misses at the vertices of handles is spread over the free surface, so that held vertices are met exactly; the report's
residual says how much that was. set_handles() costs one factorisation; a frame is one small matrix product for up to
16 handles moved from rest, otherwise one solve for x, y and z. It suits gentle edits of sheets.)",
        R"(Raises InvalidOption for an option out of its range, and set_handles() raises it if a vertex that a grid covers has no
place on the UV map.)")
        .def("control_grids", &control_grids, py::arg("poses"), py::kw_only(),
             py::arg("incoming") = py::none(), py::arg("from_rest") = py::none(),
             py::arg("grid") = py::none(),
             R"([(rows, columns, 3)] the control grids, one per part with handles, as these move them.

poses      (k, 3, 4) affine map of each handle in object space, from its rest to its posed state.
incoming   (n, 3) the shape to deform; None for the rest shape.
from_rest  None, a flag, or (k,) flags: the handles whose targets are pose * rest instead.
grid       None, or (g, 3) how far each point is moved further, as solve() takes it.

At rest, the spline of a grid fits the surface. Raises InvalidConstraint for a wrong count, shape or non-finite number.)");
}

const MethodBinding spline_surface_binding(&bind_spline_surface);

} // namespace

} // namespace sinew::bindings
