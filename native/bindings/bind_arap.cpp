// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/surface.h"
#include "native/surface/nonlinear/arap.h"

#include <pybind11/stl.h>

namespace sinew::bindings {

void bind_arap(py::module_& module)
{
    py::class_<Arap>(
        module, "Arap",
        R"(As-rigid-as-possible [Sorkine & Alexa 2007] with smooth rotations [Levi & Gotsman 2015].

Minimises sum_i r_i sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2 + alpha A sum_ij r_ij w_ij |R_i - R_j|^2
over points q and rotations R, ordered pairs, tutorial section 6. Details rotate with the surface.)")
        .def(py::init([](const SurfaceMesh& mesh, double smoothness, const std::string& cells,
                         const py::object& rigidity, int max_iterations, double tolerance) {
                 ArapOptions options;
                 options.smoothness = smoothness;
                 options.cells = choose<ArapOptions::Cells>(
                     cells, "cells",
                     {{"spokes", ArapOptions::Cells::spokes}, {"rims", ArapOptions::Cells::rims}});
                 options.rigidity = numbers(rigidity, "rigidity");
                 options.max_iterations = max_iterations;
                 options.tolerance = tolerance;
                 const py::gil_scoped_release unlocked;
                 return Arap(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("smoothness") = ArapOptions{}.smoothness,
             py::arg("cells") = "spokes", py::arg("rigidity") = 1.0,
             py::arg("max_iterations") = ArapOptions{}.max_iterations,
             py::arg("tolerance") = ArapOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
smoothness      alpha >= 0 of the smooth rotations; 0 is the textbook energy, which buckles on
                dense meshes.
cells           'spokes' [SA07] or 'rims' (spokes and rims).
rigidity        > 0, or (n,) >= 0 painted: how stiff each vertex's cell is; values below 1e-3 of
                the largest are raised to it.
max_iterations  budget of a solve, >= 1.
tolerance       >= 0: stop after two relative decreases of the energy in a row below it.

Raises InvalidOption.)")
        .def(
            "set_handles",
            [](Arap& arap, const py::object& regions, const py::object& weights, const py::object& callback) {
                const std::vector<Handle> checked = handles(regions, weights, py::none());
                const Progress ticks = progress(callback);
                const py::gil_scoped_release unlocked;
                return arap.set_handles(checked, ticks);
            },
            py::arg("handles"), py::arg("weights") = py::none(), py::arg("progress") = py::none(),
            R"(Factorise for these handles -> BindReport. Cost: two factorisations and the start's hierarchy.

handles   sequence of (h_i,) vertex index arrays, one a handle; a fixed region is a handle too.
weights   None, or one entry a handle: None, a number or (h_i,) numbers in [0, 1]. 1 holds exactly,
          less pulls with stiffness w / (1 - w) of the vertex's own, 0 lets go.
progress  None or callable(fraction, stage); returning False cancels.

Raises InvalidConstraint, FactorizationFailed or Cancelled; the object then stays as it was.)")
        .def(
            "solve",
            [](const Arap& arap, const py::object& poses, const py::object& incoming,
               const py::object& from_rest, const py::object& start, std::optional<int> max_iterations,
               std::optional<double> tolerance, const py::object& callback, const py::object& out) {
                const SolveArguments in(poses, incoming, from_rest, start);
                const Arap::Request request{in.incoming, in.from_rest(), in.start, max_iterations, tolerance};
                const Progress ticks = progress(callback);
                return solved(out, arap.rest().vertex_count(), [&](Points& positions) {
                    return arap.solve(in.poses, positions, request, ticks);
                });
            },
            py::arg("poses"), py::kw_only(), py::arg("incoming") = py::none(),
            py::arg("from_rest") = py::none(), py::arg("start") = py::none(),
            py::arg("max_iterations") = py::none(), py::arg("tolerance") = py::none(),
            py::arg("progress") = py::none(), py::arg("out") = py::none(),
            R"(Deform -> (positions (n, 3), SolveReport). No factorisation; safe from several threads.

poses           (k, 3, 4) affine map of each handle from its rest frame, object space.
incoming        (n, 3) what entered this frame; None for rest. Its edges are kept as rigid as possible.
from_rest       None, a flag, or (k,) flags: handles whose targets are pose * rest.
start           None: the result depends on the poses alone. (n, 3): warm start while dragging.
max_iterations  other budget for this call; 0 gives the start itself.
tolerance       other tolerance for this call.
progress        None or callable(fraction, stage); returning False cancels.
out             None, or a float32 array (n, 3) to write into and return; half written after an error.

Raises InvalidConstraint, InvalidOption or Cancelled. A spent budget is in the report, not an error.)")
        .def(
            "energy",
            [](const Arap& arap, const py::object& object) {
                const FloatArray array = floats(object, "positions");
                return arap.energy(points<InvalidConstraint>(array, "positions"));
            },
            py::arg("positions"),
            "Energy of given (n, 3) points over the parts with a handle, rotations fitted.");
}

} // namespace sinew::bindings
