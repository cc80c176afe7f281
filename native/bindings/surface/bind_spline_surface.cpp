// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/core/errors.h"
#include "native/methods/surface/linear/spline_surface.h"

#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

/// None, or (n, 2).
RowMatrix uv_map_of(const py::object& object)
{
    if (object.is_none())
        return {};
    const FloatArray array = floats(object, "uv_map");
    if (array.ndim() != 2 || array.shape(0) == 0 || array.shape(1) != 2)
        throw InvalidOption("uv_map: give u and v of each vertex, (n, 2) numbers");
    return Eigen::Map<const RowMatrix>(array.data(), array.shape(0), 2);
}

py::list control_grids(const SplineSurface& surface, const py::object& poses, const py::object& incoming,
                       const py::object& from_rest, const py::object& grid)
{
    Poses maps = bindings::poses(poses);
    std::optional<std::vector<bool>> aims = flags(from_rest, maps.size());
    const OptionalPoints entering(incoming, "incoming"), moves(grid, "grid");
    const SolveRequest request{.poses = std::move(maps),
                               .incoming = entering.view,
                               .from_rest = std::move(aims),
                               .grid = moves.view};
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
    bind_surface_method<SplineSurface>(module, "SplineSurface",
                                       R"(Spline surface [Farin 1997], tutorial sections 2.1 and 4.1.

A tensor-product B-spline over a UV map or a fitted plane displaces the surface, and the handles move its control grid:
by least squares where they ask for more than it can do, and else with the least change of the grid. What the spline
misses at the vertices of handles is spread over the free surface, so that held vertices are met exactly; the report's
residual says how much that was. set_handles() costs one factorisation; a frame is one small matrix product for up to
16 handles moved from rest, otherwise one solve for x, y and z. It suits gentle edits of sheets.)")
        .def(py::init([](const SurfaceMesh& mesh, int degree, int columns, int rows, double smoothing,
                         double margin, const py::object& uv_map) {
                 const SplineSurfaceOptions options{degree,    columns, rows,
                                                    smoothing, margin,  uv_map_of(uv_map)};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<SplineSurface>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("degree") = 3, py::arg("columns") = 8,
             py::arg("rows") = 8, py::arg("smoothing") = 1e-3, py::arg("margin") = 0.2,
             py::arg("uv_map") = py::none(), R"(
mesh       SurfaceMesh, the rest shape.
degree     of the spline, 1 to 5.
columns    control points of the grid of each part along u, 2 to 32; fewer than degree + 1 count as that.
rows       the same along v.
smoothing  >= 0: how much the grid resists being bent; 0 for least squares, and the least norm, alone.
margin     >= 0: how far the grid reaches into the handles, as a share of twice the distance of the farthest free
           vertex of a part from their mean.
uv_map     (n, 2) u and v of each vertex, NaN where it has none; None for the plane of least squares of each part.

Raises InvalidOption for an option out of its range, and set_handles() raises it if a vertex that a grid covers has no
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
