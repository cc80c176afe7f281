// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/subspace_laplacian.h"

#include <optional>

namespace sinew::bindings {

namespace {

void bind_subspace_laplacian(py::module_& module)
{
    SurfaceClass<SubspaceLaplacian> method(
        module, "SubspaceLaplacian",
        R"(Nonlinear Laplacian editing in the few unknowns of a cage, with the volume kept [Huang et al. 2006].

Each part with a handle lies in a cage whose vertices are the unknowns (tutorial section 6). Edges and Laplacian
coordinates follow one rotation per cluster of vertices, and parts that are closed, or nearly, keep their volume
exactly. Handles lie anywhere on the surface. set_handles() makes the cages and gathers the energy, so that an
iteration never touches the surface; a frame ends with one product of the weights, with the volume two.)");
    define_constructor(
        method,
        +[](const SubspaceLaplacianOptions& options, const SurfaceMesh& mesh, const SurfaceMesh* cage) {
            const py::gil_scoped_release unlocked;
            return std::make_shared<SubspaceLaplacian>(mesh, options,
                                                       cage ? std::optional(*cage) : std::nullopt);
        },
        {{"mesh", "SurfaceMesh, the rest shape"},
         {"cage", "SurfaceMesh, closed, around all parts with a handle; None for an automatic one per part"}},
        "Raises InvalidOption; InvalidMesh for a cage that is open, flat or inside out. set_handles() raises "
        "InvalidConstraint\nfor vertices outside the given cage.",
        py::arg("mesh"), py::kw_only(), py::arg("cage") = py::none());
    method
        .def(
            "cages",
            [](const SubspaceLaplacian& method) {
                std::vector<SurfaceMesh> cages;
                {
                    const py::gil_scoped_release unlocked;
                    cages = method.cages();
                }
                py::list list;
                for (SurfaceMesh& cage : cages)
                    list.append(py::cast(std::move(cage)));
                return list;
            },
            R"(The rest cages of the parts with a handle -> list of SurfaceMesh, none for a part that is its own subspace.

Empty before set_handles().)")
        .def(
            "clusters", numbers_of(&SubspaceLaplacian::clusters),
            R"(The cluster of each vertex -> (n,) int32, -1 in a part without a handle; empty before set_handles().)");
}

const MethodBinding subspace_laplacian_binding(&bind_subspace_laplacian);

} // namespace

} // namespace sinew::bindings
