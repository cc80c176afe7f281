// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_methods.h"
#include "native/methods/space/nonlinear/rigid_cells.h"

namespace sinew::bindings {

namespace {

py::dict cells_as_dict(const RigidCells& method)
{
    RigidCells::Cells cells;
    {
        const py::gil_scoped_release unlocked;
        cells = method.cells();
    }
    py::dict result;
    result["centres"] = to_numpy(std::move(cells.centres));
    result["sides"] = to_numpy(cells.sides);
    result["handles"] = to_numpy(cells.handles);
    result["links"] = pairs(cells.links);
    return result;
}

py::tuple cells_answer(const RigidCells& method, const ArrayLike& given, bool from_cascade, double tolerance,
                       int max_iterations)
{
    const Poses maps = poses(given);
    RigidCells::Answer answer;
    {
        const py::gil_scoped_release unlocked;
        answer = method.answer(maps, from_cascade ? RigidCells::Start::cascade : RigidCells::Start::rest,
                               tolerance, max_iterations);
    }
    return py::make_tuple(to_numpy(std::move(answer.centres)), answer.report);
}

void bind_rigid_cells(py::module_& module)
{
    bind_handle_method<RigidCells, RigidCellsOptions>(
        module, "RigidCells",
        R"(Rigid cells [Botsch, Pauly, Wicke & Gross 2007], section 7.

Cubes that fill the shape, fine at its surface and larger inside, move rigidly and hold together elastically. Points
follow the cubes around them smoothly. A closed surface bends like a solid body.)")
        .def("cells", &cells_as_dict,
             R"(The cells of the last bind -> dict.

centres  (m, 3) at rest.
sides    (m,) their lengths.
handles  (m,) which handle holds them, or -1.
links    (l, 2) pairs of cells that hold together.

Raises InvalidConstraint before bind().)")
        .def("answer", &cells_answer, py::arg("poses"), py::kw_only(), py::arg("from_cascade") = true,
             py::arg("tolerance") = 1e-4, py::arg("max_iterations") = 40,
             R"(Where the centres of the cells go -> (m, 3), SolveReport.

poses         (k, 3, 4)
from_cascade  start from the answer of coarser graphs; if not, from the resting cells.

Raises InvalidConstraint as warp_poses().)");
}

const MethodBinding rigid_cells_binding(&bind_rigid_cells);

} // namespace

} // namespace sinew::bindings
