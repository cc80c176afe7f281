// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/discretization.h"
#include "native/bindings/field.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/linear/laplacian_editing.h"

namespace sinew::bindings {

namespace {

LocalTransforms transforms_of(const std::string& name)
{
    return choose<LocalTransforms>(name, "transforms",
                                   {{"none", LocalTransforms::none},
                                    {"explicit", LocalTransforms::from_handles},
                                    {"estimated", LocalTransforms::estimated},
                                    {"implicit", LocalTransforms::implicit}});
}

void bind_laplacian_editing(py::module_& module)
{
    bind_surface_method<LaplacianEditing>(
        module, "LaplacianEditing",
        R"(Laplacian editing [Lipman et al. 2004, Sorkine et al. 2004], tutorial sections 4.5.2 and 4.5.3.

The surface keeps its differential coordinates, each turned by a local transformation: none, a blend of the maps of the
handles, rotations estimated from a first solution, or implicit ones, which are unknowns of a first linear system.
set_handles() costs one factorisation, with harmonic fields two, with implicit transformations about 20; a frame is one
solve for x, y and z, and one more per refit.)")
        .def(py::init([](const SurfaceMesh& mesh, const std::string& transforms, const std::string& laplacian,
                         const std::string& field, int refits, const std::string& second_stage,
                         bool mean_frame) {
                 const LaplacianEditingOptions options{
                     transforms_of(transforms),
                     discretization(laplacian),
                     field_of(field),
                     refits,
                     choose<SecondStage>(second_stage, "second_stage",
                                         {{"polar", SecondStage::polar}, {"length", SecondStage::length}}),
                     mean_frame};
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<LaplacianEditing>(mesh, options);
             }),
             py::arg("mesh"), py::kw_only(), py::arg("transforms") = "estimated",
             py::arg("laplacian") = "cotan_voronoi", py::arg("field") = "harmonic", py::arg("refits") = 2,
             py::arg("second_stage") = "polar", py::arg("mean_frame") = true, R"(
mesh          SurfaceMesh, the rest shape.
transforms    'none', 'explicit' (Eq. 16), 'estimated' or 'implicit': the local transformations.
laplacian     'uniform', 'cotan' or 'cotan_voronoi' (section 3.2).
field         of 'explicit', how the maps of the handles fade: 'harmonic' (Eq. 8), 'geodesic' or 'euclidean'.
refits        >= 0, of 'estimated': how often the rotations are fitted to the last solution.
second_stage  of 'implicit', how differential coordinates are turned: 'polar' by the rotations, or 'length' by the
              transformations, with their lengths kept.
mean_frame    of 'estimated' and 'implicit', whether to solve as seen from the mean rotation of the handles.

Raises InvalidOption for refits < 0, or another name.)");
}

const MethodBinding laplacian_editing_binding(&bind_laplacian_editing);

} // namespace

} // namespace sinew::bindings
