// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/choices.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/nonlinear/vector_field.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

std::vector<FieldTool> field_tools(const py::object& names)
{
    const auto tool = [](const py::handle& name) {
        return choose<FieldTool>(
            name.cast<std::string>(), "tools",
            {{"drag", FieldTool::drag}, {"twist", FieldTool::twist}, {"bend", FieldTool::bend}});
    };
    if (py::isinstance<py::str>(names))
        return {tool(names)};
    std::vector<FieldTool> tools;
    for (const py::handle& name : names)
        tools.push_back(tool(name));
    return tools;
}

std::shared_ptr<VectorField> make_vector_field(const py::object& frames, const py::object& counts,
                                               const py::object& tools, const py::object& inner,
                                               const py::object& outer, const py::object& width, int order,
                                               int steps, double tolerance)
{
    const FloatArray array = floats(frames, "points");
    const Points rest = points<InvalidConstraint>(array, "points");
    const VectorFieldOptions options{.counts =
                                         counts.is_none() ? std::vector<int>{} : integers(counts, "counts"),
                                     .tools = field_tools(tools),
                                     .inner = numbers(inner, "inner"),
                                     .outer = numbers(outer, "outer"),
                                     .width = numbers(width, "width"),
                                     .order = order,
                                     .steps = steps,
                                     .tolerance = tolerance};
    const py::gil_scoped_release unlocked;
    return std::make_shared<VectorField>(rest, options);
}

py::array_t<double> field_velocities(const VectorField& field, const py::object& control, int piece,
                                     double time, const py::object& places)
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
    py::class_<VectorField, SpaceMethod, std::shared_ptr<VectorField>>(
        module, "VectorField",
        R"(Vector fields without divergence [Angelidis et al. 2006, von Funck et al. 2006], section 7.

Tools move on their paths, one after the other, and points follow the flow of their fields: volumes stay, and space
neither tears nor folds. warp() takes the frames of the paths now. It costs O(points in reach x pieces x steps);
memory is nothing per point but their places.)")
        .def(py::init(&make_vector_field), py::arg("points"), py::arg("counts") = py::none(), py::kw_only(),
             py::arg("tools") = "drag", py::arg("inner") = 0.5, py::arg("outer") = 1.0,
             py::arg("width") = 1.0, py::arg("order") = 4, py::arg("steps") = 0, py::arg("tolerance") = 1e-5,
             R"(
points     (4 f, 3) the frames on the paths at rest, tool after tool, each by four points: its origin and the
           ends of its x, y and z axes. All frames of one tool are the same at rest.
counts     (k,) how many frames the path of each tool has; None for a single tool.
tools      'drag', 'twist' or 'bend', or (k,) of them: a ball moves and turns with the tool; what lies above
           the tool turns about its z axis; or about axes across that.
inner      a number or (k,): within this distance of a drag, all moves with the tool; below this height over a
           twist or bend, which may be negative, nothing turns.
outer      > inner, likewise: beyond it, nothing moves, or all turns.
width      > 0, a number or (k,): within this distance of the axis of a twist or bend all turns, and at twice
           the distance nothing does.
order      1, 2 or 4, of the Runge-Kutta rule, if steps is given.
steps      on each piece of a path; 0 for as many as each point needs.
tolerance  of a point on one piece of a path, as a share of outer, if steps is 0.

Raises InvalidConstraint for frames that are not finite, flat, or differ at rest, InvalidOption.)")
        .def("velocities", &field_velocities, py::arg("cage_points"), py::arg("piece"), py::arg("time"),
             py::arg("points"), R"(The field of one piece of the paths -> (n, 3).

cage_points  (4 f, 3) the frames, as warp() takes them.
piece        of the pieces on which a tool moves, in order.
time         in [0, 1], on this piece.
points       (n, 3) where; they need not be bound.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, or a piece that there is not.)")
        .def(
            "piece_count",
            [](const VectorField& field, const py::object& control) {
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
