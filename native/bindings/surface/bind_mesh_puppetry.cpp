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
6). p is the incoming shape. set_handles() costs two factorisations and a solve per handle.)");
}

const MethodBinding mesh_puppetry_binding(&bind_mesh_puppetry);

} // namespace

} // namespace sinew::bindings
