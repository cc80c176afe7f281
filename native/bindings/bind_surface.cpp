// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/representation.h"
#include "native/bindings/surface.h"

#include <pybind11/stl.h>

namespace sinew::bindings {

namespace {

FreeParts free_parts_of(const std::string& choice, const OptionalArray& stiffness)
{
    FreeParts options;
    options.follow = choose<bool>(choice, "free_parts", {{"stay", false}, {"follow", true}});
    if (!stiffness.is_none())
        options.stiffness = numbers(stiffness, "free_part_stiffness");
    return options;
}

BindReport set_handles(SurfaceMethod& method, const ArrayLikes& regions, const OptionalArrays& weights,
                       const OptionalArray& continuity, const Callback& callback,
                       const std::string& free_parts, const OptionalArray& free_part_stiffness)
{
    const std::vector<Handle> checked = handles(regions, weights, continuity);
    const FreeParts options = free_parts_of(free_parts, free_part_stiffness);
    const Progress ticks = progress(callback);
    const py::gil_scoped_release unlocked;
    return method.set_handles(checked, ticks, options);
}

BindReport rebind_surface(SurfaceMethod& method, SurfaceMethod& former, const ArrayLikes& regions,
                          const OptionalArrays& weights, const OptionalArray& continuity,
                          const Callback& callback, const std::string& free_parts,
                          const OptionalArray& free_part_stiffness)
{
    const std::vector<Handle> checked = handles(regions, weights, continuity);
    const FreeParts options = free_parts_of(free_parts, free_part_stiffness);
    const Progress ticks = progress(callback);
    const py::gil_scoped_release unlocked;
    return method.rebind(former, checked, ticks, options);
}

bool can_reuse_surface(const SurfaceMethod& method, const py::object& former)
{
    if (!py::isinstance<SurfaceMethod>(former))
        return false;
    const auto& other = former.cast<const SurfaceMethod&>();
    const py::gil_scoped_release unlocked;
    return method.can_reuse(other);
}

Solved solve(const SurfaceMethod& method, const ArrayLike& poses, const OptionalArray& incoming,
             const OptionalFlags& from_rest, const OptionalArray& start, std::optional<int> max_iterations,
             std::optional<double> tolerance, const Callback& callback, const Out& out, int substeps,
             double morph, const OptionalArray& grid)
{
    Poses maps = bindings::poses(poses);
    std::optional<std::vector<bool>> aims = flags(from_rest, maps.size());
    const OptionalPoints entering(incoming, "incoming"), first(start, "start"), moves(grid, "grid");
    SolveRequest request{std::move(maps), entering.view, std::move(aims),    first.view,
                         max_iterations,  tolerance,     progress(callback), substeps};
    if (moves.view)
        request.extra.emplace<GridMoves>(*moves.view);
    else if (morph != 0.0)
        request.extra.emplace<Morph>(morph);
    return solved(out, method.rest().vertex_count(),
                  [&](Points& positions) { return method.solve(request, positions); });
}

} // namespace

void bind_surface(py::module_& module)
{
    py::class_<SurfaceMethod, std::shared_ptr<SurfaceMethod>>(
        module, "SurfaceMethod", R"(What every deformation of a surface by handles on it can do.

Threads may share an object. solve() runs in any number of them at once. Calls that bind (set_handles(), rebind() and
those that change an option) have their objects to themselves: they wait until other calls have ended, and other calls
wait for them. A progress callback must not wait for the call that it belongs to, so there such a call raises
ObjectInUse.)")
        .def("set_handles", &set_handles, py::arg("handles"), py::arg("weights") = py::none(),
             py::arg("continuity") = py::none(), py::arg("progress") = py::none(), py::kw_only(),
             py::arg("free_parts") = "stay", py::arg("free_part_stiffness") = py::none(),
             R"(Factorise for these handles -> BindReport. Cost: see the class.

handles     sequence of (h_i,) vertex index arrays, one per handle; a fixed region is a handle, too. [[0, 7]] is one
            handle of two vertices; [0, 7] raises a TypeError.
weights     None, or one entry per handle: None, a number or (h_i,) numbers in [0, 1]. 1 holds a vertex exactly,
            less pulls it with w / (1 - w) times its own stiffness, 0 leaves it free.
continuity  None (2), a number, or one per handle, in [0, 2]: C0 to C2 at the region's border, as far
            as the order of the method allows. C1 needs regions two rings deep, C2 three.
progress    None or callable(fraction, stage); returning False cancels.
free_parts  what connected parts without a handle do. 'stay': they keep the incoming shape. 'follow': they ride
            on the parts that have a handle, rigidly where they are compact or small, bending where they are
            long; they enter no system, and solve() reads their motion off the surface they lay on.
free_part_stiffness
            None (0), a number or (n,) numbers in [0, 1], of which each part takes the mean: 0 bends as its
            size says, 1 moves as one rigid body.

Raises InvalidConstraint, InvalidOption, FactorizationFailed, ObjectInUse or Cancelled; the object then stays as
it was.)")
        .def("rebind", &rebind_surface, py::arg("former"), py::arg("handles"),
             py::arg("weights") = py::none(), py::arg("continuity") = py::none(),
             py::arg("progress") = py::none(), py::kw_only(), py::arg("free_parts") = "stay",
             py::arg("free_part_stiffness") = py::none(),
             R"(As set_handles(), taking over from another object what is still valid -> BindReport.

former   SurfaceMethod. If can_reuse(former), it has no handles afterwards; otherwise it stays as it was.
handles  (h_i,) vertex indices each; this and the others as in set_handles().

The report's `reuse` and `changed` say how much was taken over and what differs; other free parts keep the
factor. Raises InvalidConstraint, InvalidOption, FactorizationFailed, ObjectInUse or Cancelled; both objects then
stay as they were.)")
        .def("can_reuse", &can_reuse_surface, py::arg("former"),
             "Whether rebind() would take anything over from another method. Cost: O(n), to compare.")
        .def("solve", &solve, py::arg("poses"), py::kw_only(), py::arg("incoming") = py::none(),
             py::arg("from_rest") = py::none(), py::arg("start") = py::none(),
             py::arg("max_iterations") = py::none(), py::arg("tolerance") = py::none(),
             py::arg("progress") = py::none(), py::arg("out") = py::none(), py::arg("substeps") = 1,
             py::arg("morph") = 0.0, py::arg("grid") = py::none(),
             R"(Deform -> (positions (n, 3), SolveReport). No factorisation; safe from several threads.

poses           (k, 3, 4) affine map of each handle in object space, from its rest to its posed state.
incoming        (n, 3) the shape to deform; None for the rest shape. A handle's targets are pose * incoming.
from_rest       None, a flag, or (k,) flags: the handles whose targets are pose * rest instead.
start           (n, 3) the shape to start from while a control is dragged; with None, the result depends on
                the poses alone.
max_iterations  largest number of iterations of this call; 0 gives the start itself.
tolerance       tolerance of this call.
progress        None or callable(fraction, stage); returning False cancels.
out             None, or a float32 array (n, 3) to write into and return. After an error, parts of it may
                have been written.
substeps        >= 1: in how many steps the handles go to their poses. ThinShell and LaplacianEditing with 'none' or
                'implicit' bind the shape of each step anew, which takes as many binds; 'estimated' starts from
                it. Multiresolution passes them on to its base. The others would reach the same shape, and take one
                step.
morph           in [0, 1]: how far PyramidCoordinates goes to its target shape; the others do not use it.
grid            None, or (g, 3) how far each point of the control grids of a SplineSurface is moved from where the
                handles lead it, in the order of control_grids(). The others have no grid, and do not use it.

A linear method accepts start, max_iterations, tolerance and progress, but does not use them.
Raises InvalidConstraint for a wrong count, shape or non-finite number, InvalidOption or Cancelled. If the
iterations are used up, the report says so; this is no error.)")
        .def_property_readonly("rest", &SurfaceMethod::rest, "SurfaceMesh, the rest shape.")
        .def("__repr__", [](const py::object& self) {
            const int count = self.cast<const SurfaceMethod&>().rest().vertex_count();
            return representation(self, std::to_string(count) + " vertices");
        });
}

} // namespace sinew::bindings
