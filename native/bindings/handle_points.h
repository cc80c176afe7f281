// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/bindings/warped.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

/// Handle points from the arguments of a constructor in Python: counts is None where each point is a handle,
/// and weights where all points are held fully.
inline HandlePoints handle_points(const ArrayLike& given, const OptionalArray& counts,
                                  const OptionalArray& weights = py::none())
{
    const FloatArray array = floats(given, "points");
    const PointsView view = points<InvalidConstraint>(array, "points");
    std::vector<int> of_handles;
    if (!counts.is_none()) {
        of_handles = integers(counts, "counts");
        if (of_handles.empty())
            throw InvalidConstraint("counts: there is no handle");
    }
    return HandlePoints(view, std::move(of_handles),
                        weights.is_none() ? std::vector<double>{} : numbers(weights, "weights"));
}

/// What the points of handles are, for the documentation of a constructor.
inline std::vector<Described> described_handle_points()
{
    return {
        {"points", "(c, 3) the points of the handles at rest, handle after handle"},
        {"counts",
         "(k,) how many points each handle has; None if each point is a handle, which moves it anywhere. A "
         "handle of more points moves them by one affine map"},
        {"weights",
         "None (1), or (c,) in (0, 1]: how strongly each point is held. Where several handles hold one "
         "place, it goes to the mean of their targets by these weights; one that holds it fully "
         "overrules the others"}};
}
constexpr const char* refused_handle_points = "Raises InvalidConstraint for points that are not finite or "
                                              "none, or counts that do not fit; InvalidOption.";

/// Gives the class of a method on handle points warp_poses(), which poses the handles in native code.
/// \param posed  what warp() takes of the handles.
template <class Method>
void define_warp_poses(py::class_<Method, SpaceMethod, std::shared_ptr<Method>>& defined,
                       Points (HandlePoints::*posed)(const Poses&) const)
{
    defined.def(
        "warp_poses",
        [posed](const Method& method, const ArrayLike& given, const Out& out, const OptionalArray& incoming,
                const OptionalFlags& from_rest) -> Singles {
            const Poses maps = poses(given);
            flags(from_rest, maps.size());
            const OptionalPoints entering(incoming, "incoming");
            return warped(method, out, [&](PositionsOut positions, std::optional<Eigen::Index> room) {
                method.warp(view((method.handles().*posed)(maps)), entering.view, positions, room);
            });
        },
        py::arg("poses"), py::arg("out") = py::none(), py::kw_only(), py::arg("incoming") = py::none(),
        py::arg("from_rest") = py::none(),
        R"(Where posed handles move the bound points -> (n, 3). As warp() of the control that they pose.

poses      (k, 3, 4) affine map of each handle in object space, from its rest to its posed state. One of a single point
           moves it, and turns nothing.
out        None, or a writable C-contiguous (n, 3) float32 array to write into, which is returned.
incoming   (n, 3) the shape to deform in this frame; None for the bound points.
from_rest  None, one flag or one per handle, as HandleMethod.warp_poses() takes them. Here they change nothing: the same
           displacements are added to each incoming shape.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, two handles that take one point to
two places, or before bind().)");
}

/// The class of a method on handle points, with what all of them have, without a constructor.
template <class Method>
py::class_<Method, SpaceMethod, std::shared_ptr<Method>> points_class(py::module_& module, const char* name,
                                                                      const char* doc)
{
    py::class_<Method, SpaceMethod, std::shared_ptr<Method>> result(module, name, doc);
    result.def_property_readonly(
        "control",
        [](const Method& method) {
            Points control = method.handles().control();
            return to_numpy(std::move(control));
        },
        R"((r, 3) the control at rest, whose pose warp() takes: the point of a handle of one point; of any other
four points, a centre and a step from it along each axis, to which the handle's map is applied.)");
    define_warp_poses(result, &HandlePoints::posed_control);
    return result;
}

/// Defines the class of a method on handle points, and its constructor, which takes the handles and then its
/// options. The caller adds what only this method can do.
template <class Method, class Options>
py::class_<Method, SpaceMethod, std::shared_ptr<Method>>
bind_points_method(py::module_& module, const char* name, const char* doc,
                   const char* raises = refused_handle_points)
{
    auto method = points_class<Method>(module, name, doc);
    define_constructor(
        method,
        +[](const Options& options, const ArrayLike& points, const OptionalArray& counts,
            const OptionalArray& weights) {
            HandlePoints handles = handle_points(points, counts, weights);
            const py::gil_scoped_release unlocked;
            return std::make_shared<Method>(std::move(handles), options);
        },
        described_handle_points(), raises, py::arg("points"), py::arg("counts") = py::none(), py::kw_only(),
        py::arg("weights") = py::none());
    return method;
}

} // namespace sinew::bindings
