// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/discretization.h"
#include "native/bindings/surface.h"
#include "native/surface/linear/thin_shell.h"

namespace sinew::bindings {

void bind_thin_shell(py::module_& module)
{
    py::class_<ThinShell>(module, "ThinShell",
                          R"(Linear thin shell [Botsch & Kobbelt 2004], tutorial section 4.3.

Displacement d with -k_s Delta d + k_b Delta^2 d - k_v Delta^3 d = 0 on free vertices (Eq. 12).
Factorised once in set_handles(); a frame is one small matrix product for up to 16 handles moved
from rest, else one solve of x, y and z. Fair for translations and gentle bends; details do not
rotate with the surface.)")
        .def(py::init([](const SurfaceMesh& mesh, const py::object& stretching, const py::object& bending,
                         const py::object& variation, const std::string& laplacian, bool affine_basis) {
                 const ThinShellOptions options{numbers(stretching, "stretching"),
                                                numbers(bending, "bending"), numbers(variation, "variation"),
                                                discretization(laplacian), affine_basis};
                 const py::gil_scoped_release unlocked;
                 return ThinShell(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("stretching") = 0.0, py::arg("bending") = 1.0,
             py::arg("variation") = 0.0, py::arg("laplacian") = "cotan_voronoi",
             py::arg("affine_basis") = true, R"(
mesh          SurfaceMesh, the rest shape.
stretching    k_s >= 0, or (n,) painted: order 1, membrane.
bending       k_b >= 0, or (n,) painted: order 2, thin plate; in units of k_s length^2.
variation     k_v >= 0, or (n,) painted: order 3, minimum variation; in units of k_s length^4.
laplacian     'uniform', 'cotan' or 'cotan_voronoi' (section 3.2).
affine_basis  precompute the answer to affine handle motion.

Raises InvalidOption for negative, NaN or all-zero stiffnesses.)")
        .def(
            "set_handles",
            [](ThinShell& shell, const py::object& regions, const py::object& weights,
               const py::object& continuity, const py::object& callback) {
                const std::vector<Handle> checked = handles(regions, weights, continuity);
                const Progress ticks = progress(callback);
                const py::gil_scoped_release unlocked;
                return shell.set_handles(checked, ticks);
            },
            py::arg("handles"), py::arg("weights") = py::none(), py::arg("continuity") = py::none(),
            py::arg("progress") = py::none(),
            R"(Factorise for these handles -> BindReport. Cost: one factorisation; where the last
handles stay held and little is added, the part of the factor that it reaches.

handles     sequence of (h_i,) vertex index arrays, one a handle; a fixed region is a handle too.
weights     None, or one entry a handle: None, a number or (h_i,) numbers in [0, 1]. 1 holds exactly,
            less pulls with stiffness w / (1 - w) of the vertex's own, 0 lets go.
continuity  None (2), a number, or one a handle, in [0, 2]: C0 to C2 at the region's border, as far
            as the order allows. C1 needs regions two rings deep, C2 three.
progress    None or callable(fraction, stage); returning False cancels.

Raises InvalidConstraint, FactorizationFailed or Cancelled; the object then stays as it was.)")
        .def(
            "set_stiffness",
            [](ThinShell& shell, const py::object& stretching, const py::object& bending,
               const py::object& variation, const py::object& callback) {
                const auto s = numbers(stretching, "stretching");
                const auto b = numbers(bending, "bending");
                const auto v = numbers(variation, "variation");
                const Progress ticks = progress(callback);
                const py::gil_scoped_release unlocked;
                return shell.set_stiffness(s, b, v, ticks);
            },
            py::arg("stretching"), py::arg("bending"), py::arg("variation") = 0.0,
            py::arg("progress") = py::none(),
            "Other k_s, k_b, k_v under the same handles -> BindReport. Cost: numeric factorisation only, of\n"
            "the part that a change on a few vertices reaches.")
        .def(
            "solve",
            [](const ThinShell& shell, const py::object& poses, const py::object& incoming,
               const py::object& from_rest, const py::object&, const py::object&, const py::object&,
               const py::object& out) {
                const SolveArguments in(poses, incoming, from_rest, py::none());
                return solved(out, shell.rest().vertex_count(), [&](Points& positions) {
                    return shell.solve(in.poses, positions, in.incoming, in.from_rest());
                });
            },
            py::arg("poses"), py::kw_only(), py::arg("incoming") = py::none(),
            py::arg("from_rest") = py::none(), py::arg("start") = py::none(),
            py::arg("max_iterations") = py::none(), py::arg("progress") = py::none(),
            py::arg("out") = py::none(),
            R"(Deform -> (positions (n, 3), SolveReport). No factorisation; safe from several threads.

poses      (k, 3, 4) affine map of each handle from its rest frame, object space.
incoming   (n, 3) what entered this frame; None for rest. Handle targets are pose * incoming.
from_rest  None, a flag, or (k,) flags: handles whose targets are pose * rest.
start, max_iterations, progress: accepted as by every surface method; a linear one needs none.
out        None, or a float32 array (n, 3) to write into and return; half written after an error.

Raises InvalidConstraint for a wrong count, shape or non-finite number.)");
}

} // namespace sinew::bindings
