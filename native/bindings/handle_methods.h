// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/handle_points.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/nonlinear/handles/handle_method.h"

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

/// (l, 2)
py::array_t<int> pairs(const std::vector<std::array<int, 2>>& list);

/// Defines the class of a space method that handles move, and its constructor, which takes the shape and the
/// handles and then the method's options. The caller adds what only this method can do.
template <class Method, class Options>
py::class_<Method, HandleMethod, std::shared_ptr<Method>>
bind_handle_method(py::module_& module, const char* name, const char* doc)
{
    py::class_<Method, HandleMethod, std::shared_ptr<Method>> method(module, name, doc);
    define_constructor(
        method,
        +[](const Options& options, const SurfaceMesh& mesh, const ArrayLike& points,
            const OptionalArray& counts, const OptionalArray& weights) {
            HandlePoints held = handle_points(points, counts, weights);
            const py::gil_scoped_release unlocked;
            return std::make_shared<Method>(mesh, std::move(held), options);
        },
        {{"mesh", "SurfaceMesh, the shape whose space is deformed; one without faces for curves and clouds "
                  "of points"},
         {"points", "(c, 3) the rest points that handles hold, handle after handle"},
         {"counts", "None, which makes each point a handle, or (k,) how many points each handle holds"},
         {"weights", "None (1), or (c,) in (0, 1]: how strongly each point is held"}},
        "Raises InvalidConstraint for handles without points, or numbers that are not finite; InvalidOption.",
        py::arg("mesh"), py::arg("points"), py::arg("counts") = py::none(), py::kw_only(),
        py::arg("weights") = py::none());
    return method;
}

} // namespace sinew::bindings
