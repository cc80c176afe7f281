// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_points.h"
#include "native/methods/multiresolution/multiresolution_space.h"

#include <string>

namespace sinew::bindings {

namespace {

void bind_multiresolution_space(py::module_& module)
{
    auto method = points_class<MultiresolutionSpace>(
        module, "MultiresolutionSpace",
        R"(Multiresolution deformation in space [Marinov, Botsch & Kobbelt 2007], sections 4.4 and 5.3.

A space method on handle points moves a smooth base of a mesh, and the details are put back on it: they turn with the
base where it bends. Vertices at handle points have no details, so handles are met as the space method meets them.)");
    std::vector<Described> arguments = described_handle_points();
    arguments.insert(arguments.begin() + 1,
                     {{"base", "SpaceMethod on the same handles; it belongs to this object from now on"},
                      {"mesh", "SurfaceMesh, the rest shape; all of its vertices can be bound, or some"}});
    define_constructor(
        method,
        +[](const MultiresolutionOptions& options, const ArrayLike& points,
            const std::shared_ptr<SpaceMethod>& base, const SurfaceMesh& mesh, const OptionalArray& counts,
            const OptionalArray& weights) {
            HandlePoints handles = handle_points(points, counts, weights);
            const py::gil_scoped_release unlocked;
            return std::make_shared<MultiresolutionSpace>(std::move(handles), base, mesh, options);
        },
        std::move(arguments), refused_handle_points, py::arg("points"), py::arg("base").none(false),
        py::arg("mesh"), py::arg("counts") = py::none(), py::kw_only(), py::arg("weights") = py::none());
}

const MethodBinding multiresolution_space_binding(&bind_multiresolution_space);

} // namespace

} // namespace sinew::bindings
