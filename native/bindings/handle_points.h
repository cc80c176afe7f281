// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"

#include <memory>
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
