// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

/// Handle points from the arguments of a constructor in Python: counts is None where each point is a handle,
/// and weights where all points are held fully.
inline HandlePoints handle_points(const py::object& given, const py::object& counts,
                                  const py::object& weights = py::none())
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

/// What the constructors of methods on handle points say about these, and then about their own arguments.
inline std::string with_handle_points(const char* own)
{
    return std::string(R"(
points     (c, 3) the points of the handles at rest, handle after handle.
counts     (k,) how many points each handle has; None if each point is a handle, which moves it anywhere. A handle of
           more points moves them by one affine map.
weights    None (1), or (c,) in (0, 1]: how strongly each point is held. Where several handles hold one place, it goes to
           the mean of their targets by these weights; one that holds it fully overrules the others.
)") + own;
}

/// The class of a method on handle points, with what all of them have. The caller adds a constructor.
template <class Method>
py::class_<Method, SpaceMethod, std::shared_ptr<Method>> bind_points_method(py::module_& module,
                                                                            const char* name, const char* doc)
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

} // namespace sinew::bindings
