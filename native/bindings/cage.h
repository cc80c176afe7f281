// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/cage_coordinates.h"

#include <memory>
#include <string>
#include <utility>

namespace sinew::bindings {

/// Calls a member function that reads what a bind made. Another thread may bind now: the GIL is free while
/// this one waits.
template <auto member, class Method>
auto read(const Method& method)
{
    const py::gil_scoped_release unlocked;
    const AccessLock shared = method.reading();
    return (method.*member)();
}

/// Defines the class of a cage method, and its constructor, which takes the arguments that all cage methods
/// have and then its options. The caller adds what only this method can do.
template <class Method, class Options>
py::class_<Method, CageCoordinates, std::shared_ptr<Method>>
bind_cage_method(py::module_& module, const char* name, const char* doc)
{
    py::class_<Method, CageCoordinates, std::shared_ptr<Method>> method(module, name, doc);
    define_constructor(
        method,
        +[](const Options& given, const SurfaceMesh& cage, const Chosen<WeightPrecision>& precision,
            double threshold) {
            Options options = given;
            options.weights = {precision.value("precision"), threshold};
            const py::gil_scoped_release unlocked;
            return std::make_shared<Method>(Cage(cage, Method::takes_flat), options);
        },
        {{"cage", std::string("SurfaceMesh, the closed rest cage, with faces that look outwards") +
                      (Method::takes_flat ? ", or one in a plane: its outline counts" : "")},
         {"precision", "of the weights: 'single' (half the memory and time of a warp) or 'double'"},
         {"threshold",
          "weights of a smaller magnitude are dropped, the others are changed so that their sum stays the "
          "same, and stored as a sparse matrix; 0 keeps all, as a dense matrix"}},
        "Raises InvalidMesh for a cage that is open, without a volume or inside out; InvalidOption.",
        py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0);
    return method;
}

} // namespace sinew::bindings
