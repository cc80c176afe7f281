// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/core/errors.h"
#include "native/methods/multiresolution/transfer/mesh_transfer.h"

#include <memory>
#include <string>
#include <utility>

namespace sinew::bindings {

namespace {

void bind_mesh_transfer(py::module_& module)
{
    py::class_<MeshTransfer>(
        module, "MeshTransfer",
        R"(Deformation transfer from one mesh to another [Sumner & Popovic 2004], tutorial section 4.4.4.

Both have the same faces, and other proportions. Each face of the target is deformed as that of the source, by one
Poisson solve per call; the centre of each part moves with that of the source, in proportion to the size.)")
        .def(py::init([](const SurfaceMesh& source, const SurfaceMesh& target) {
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<MeshTransfer>(source, target);
             }),
             py::arg("source"), py::arg("target"), R"(
source, target  SurfaceMesh, the rest shapes; vertex k of one is vertex k of the other.

Costs one Poisson factor. Raises InvalidMesh if the target has another number of vertices or other faces, which the
error names; FactorizationFailed.)")
        .def(
            "transfer",
            [](const MeshTransfer& both, const ArrayLike& source) {
                const FloatArray moved = floats(source, "source");
                const PointsView given = points<InvalidConstraint>(moved, "source");
                Points target;
                {
                    const py::gil_scoped_release unlocked;
                    both.transfer(given, target);
                }
                return to_numpy(std::move(target));
            },
            py::arg("source"),
            R"(Deform the target -> (n, 3). No factorisation; safe from several threads.

source  (n, 3) the source, deformed.

Raises InvalidConstraint for a wrong shape or a non-finite number.)")
        .def("__repr__", [](const MeshTransfer& both) {
            return "<MeshTransfer: " + std::to_string(both.vertex_count()) + " vertices>";
        });
}

const MethodBinding mesh_transfer_binding(&bind_mesh_transfer);

} // namespace

} // namespace sinew::bindings
