// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/representation.h"
#include "native/bindings/warped.h"
#include "native/methods/space/method.h"

#include <pybind11/stl.h>

#include <memory>
#include <optional>

namespace sinew::bindings {

namespace {

SpaceReport bind_points(SpaceMethod& method, const ArrayLike& rest, const Callback& callback)
{
    const FloatArray array = floats(rest, "points");
    const PointsView view = points<InvalidConstraint>(array, "points");
    const Progress ticks = progress(callback);
    const py::gil_scoped_release unlocked;
    return method.bind(view, ticks);
}

SpaceReport rebind_space(SpaceMethod& method, SpaceMethod& former, const ArrayLike& rest,
                         const Callback& callback)
{
    const FloatArray array = floats(rest, "points");
    const PointsView view = points<InvalidConstraint>(array, "points");
    const Progress ticks = progress(callback);
    const py::gil_scoped_release unlocked;
    return method.rebind(former, view, ticks);
}

bool can_reuse_space(const SpaceMethod& method, const py::object& former, const ArrayLike& rest)
{
    const FloatArray array = floats(rest, "points");
    const PointsView view = points<InvalidConstraint>(array, "points");
    if (!py::isinstance<SpaceMethod>(former))
        return false;
    const auto& other = former.cast<const SpaceMethod&>();
    const py::gil_scoped_release unlocked;
    return method.can_reuse(other, view);
}

Singles warp(const SpaceMethod& method, const ArrayLike& control, const Out& out,
             const OptionalArray& incoming)
{
    const FloatArray array = floats(control, "cage_points");
    const PointsView view = points<InvalidConstraint>(array, "cage_points");
    const OptionalPoints entering(incoming, "incoming");
    return warped(method, out, [&](PositionsOut positions, std::optional<Eigen::Index> room) {
        method.warp(view, entering.view, positions, room);
    });
}

} // namespace

void bind_space(py::module_& module)
{
    py::class_<SpaceReport>(module, "CageReport", "What bind() or rebind() of a space method did.")
        .def_property_readonly(
            "reuse", [](const SpaceReport& report) { return name_of(report.reuse); },
            "What rebind() took over: 'anew' for nothing, or 'kept' for everything.")
        .def_readonly("changed", &SpaceReport::changed,
                      "What differs from the object that rebind() was given.")
        .def_readonly("point_count", &SpaceReport::point_count, "Number of points bound.")
        .def_property_readonly(
            "outside", [](const SpaceReport& report) { return to_numpy(report.outside); },
            "(k,) points outside the cage.")
        .def_readonly(
            "dropped", &SpaceReport::dropped,
            "How much the threshold changed the weights of a point, at most. The error of a warped point is "
            "at most this times the longest move of a cage vertex.")
        .def_readonly("error", &SpaceReport::error,
                      "Estimate of the largest error of a weight; 0 for a closed form.")
        .def_readonly("remarks", &SpaceReport::remarks,
                      "What the control cannot carry, and what is used instead; a list of texts.")
        .def_readonly("weight_bytes", &SpaceReport::weight_bytes, "Memory of the weights.")
        .def_readonly("seconds", &SpaceReport::seconds, "Wall clock time of the call.")
        .def("__repr__", [](const SpaceReport& report) {
            return "<CageReport: " + std::to_string(report.point_count) + " points, " +
                   std::to_string(report.outside.size()) + " outside>";
        });

    py::class_<SpaceMethod, std::shared_ptr<SpaceMethod>>(
        module, "SpaceMethod", R"(What every deformation of the space around points can do.

Threads may share an object. warp() runs in any number of them at once. bind() and rebind() have their objects to
themselves: they wait until other calls have ended, and other calls wait for them. A progress callback must not wait
for the call that it belongs to, so there such a call raises ObjectInUse.)")
        .def("bind", &bind_points, py::arg("points"), py::arg("progress") = py::none(),
             R"(Compute the weights of points -> CageReport.

points    (n, 3) rest points, in the frame of the cage.
progress  None or callable(fraction, stage); returning False cancels.

Raises InvalidConstraint (a point is not finite, or the method has no weights for it), PointsOutside, OutOfMemory,
ObjectInUse or Cancelled; the object then stays as it was.)")
        .def("rebind", &rebind_space, py::arg("former"), py::arg("points"), py::arg("progress") = py::none(),
             R"(As bind(), taking over the weights of another object where they are the same -> CageReport.

former    SpaceMethod. If can_reuse(former, points), it has no bound points afterwards; otherwise it stays
          as it was.
points    (n, 3); this and progress as in bind().

Raises InvalidConstraint, OutOfMemory, ObjectInUse or Cancelled; both objects then stay as they were.)")
        .def("can_reuse", &can_reuse_space, py::arg("former"), py::arg("points"),
             R"(Whether rebind() would take over the weights of another method. Cost: O(n), to compare.

points  (n, 3) rest points. Raises InvalidConstraint for another shape.)")
        .def("warp", &warp, py::arg("cage_points"), py::arg("out") = py::none(), py::kw_only(),
             py::arg("incoming") = py::none(),
             R"(Where the posed control moves the bound points -> (n, 3).

cage_points  (c, 3) the posed control, for example the vertices of a cage.
out          None, or a writable C-contiguous (n, 3) float32 array to write into, which is returned.
incoming     (n, 3) the shape to which the displacements are added; None for the bound points.

The control at rest gives exactly the incoming shape.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, or before bind().)")
        .def("__repr__",
             [](const py::object& self) { return representation(self, "a deformation of space"); });
}

} // namespace sinew::bindings
