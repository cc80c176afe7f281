// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/nonlinear/vector_field.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

py::array_t<double> field_velocities(const VectorField& field, const ArrayLike& control, int piece,
                                     double time, const OptionalArray& places)
{
    const FloatArray posed = floats(control, "cage_points"), array = floats(places, "points");
    const PointsView control_view = points<InvalidConstraint>(posed, "cage_points");
    const PointsView at = points<InvalidConstraint>(array, "points");
    Points found;
    {
        const py::gil_scoped_release unlocked;
        found = field.velocities(control_view, piece, time, at);
    }
    return to_numpy(std::move(found));
}

void bind_vector_field(py::module_& module)
{
    py::class_<VectorField, SpaceMethod, std::shared_ptr<VectorField>> field(
        module, "VectorField",
        R"(Vector fields without divergence [Angelidis et al. 2006, von Funck et al. 2006], section 7.

Tools move on their paths, one after the other, and points follow the flow of their fields: volumes stay, and space
neither tears nor folds. warp() takes the frames of the paths now. It costs O(points in reach x pieces x steps);
memory is nothing per point but their places.)");
    define_constructor(
        field,
        +[](const VectorFieldOptions& given, const ArrayLike& frames, const OptionalArray& counts) {
            const FloatArray array = floats(frames, "points");
            const Points rest = points<InvalidConstraint>(array, "points");
            VectorFieldOptions options = given;
            if (!counts.is_none())
                options.counts = integers(counts, "counts");
            const py::gil_scoped_release unlocked;
            return std::make_shared<VectorField>(rest, options);
        },
        {{"points", "(4 f, 3) the frames on the paths at rest, tool after tool, each by four points: its "
                    "origin and the "
                    "ends of its x, y and z axes; all frames of one tool are the same at rest"},
         {"counts", "(k,) how many frames the path of each tool has; None for a single tool"}},
        "Raises InvalidConstraint for frames that are not finite, flat, or differ at rest, InvalidOption.",
        py::arg("points"), py::arg("counts") = py::none(), py::kw_only());
    field
        .def("velocities", &field_velocities, py::arg("cage_points"), py::arg("piece"), py::arg("time"),
             py::arg("points"), R"(The field of one piece of the paths -> (n, 3).

cage_points  (4 f, 3) the frames, as warp() takes them.
piece        of the pieces on which a tool moves, in order.
time         in [0, 1], on this piece.
points       (n, 3) where; they need not be bound.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, or a piece that there is not.)")
        .def(
            "piece_count",
            [](const VectorField& field, const ArrayLike& control) {
                const FloatArray array = floats(control, "cage_points");
                return field.piece_count(points<InvalidConstraint>(array, "cage_points"));
            },
            py::arg("cage_points"), R"(On how many pieces of the paths a tool moves.

cage_points  (4 f, 3) the frames, as warp() takes them.

Raises InvalidConstraint for a wrong count or shape, or a number that is not finite.)")
        .def_property_readonly("tool_count", &VectorField::tool_count, "Number of tools.");
}

const MethodBinding vector_field_binding(&bind_vector_field);

} // namespace

} // namespace sinew::bindings
