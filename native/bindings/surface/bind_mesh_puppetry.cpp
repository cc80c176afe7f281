// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

namespace sinew::bindings {

namespace {

void bind_mesh_puppetry(py::module_& module)
{
    bind_surface_method<MeshPuppetry>(module, "MeshPuppetry",
                                      R"(The skin of a puppet [Shi et al. 2007].

Handles are the rigid middles of limbs, for example those of Skeleton.regions(), and their poses those of
Skeleton.poses(). Minimises sum_i [sum_j w_ij |(q_i - q_j) - R_i (p_i - p_j)|^2 + lambda A / m_i |(L q)_i -
R_i (L p)_i|^2] / 2 over points q and rotations R, which are those of the limbs at their vertices (tutorial section
6). p is the incoming shape. set_handles() costs two factorisations and a solve per handle.)")
        .def(py::init([](const SurfaceMesh& mesh, double bending, int max_iterations, double tolerance) {
                 const MeshPuppetryOptions options{bending, max_iterations, tolerance};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<MeshPuppetry>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("bending") = MeshPuppetryOptions{}.bending,
             py::arg("max_iterations") = MeshPuppetryOptions{}.max_iterations,
             py::arg("tolerance") = MeshPuppetryOptions{}.tolerance, R"(
mesh            SurfaceMesh, the rest shape.
bending         lambda >= 0: how much bends and bumps are kept, beside the lengths of edges.
max_iterations  largest number of iterations of a solve, >= 1.
tolerance       >= 0: stop when the relative decrease of the energy is below it twice in succession.

Raises InvalidOption.)");
}

const MethodBinding mesh_puppetry_binding(&bind_mesh_puppetry);

} // namespace

} // namespace sinew::bindings
