// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/creases.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/cage_coordinates.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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
    std::vector<Described> described{
        {"cage", std::string("SurfaceMesh, the closed rest cage, with faces that look outwards") +
                     (Method::takes_flat ? ", or one in a plane: its outline counts" : "")},
        {"precision", "of the weights: 'single' (half the memory and time of a warp) or 'double'"},
        {"threshold",
         "weights of a smaller magnitude are dropped, the others are changed so that their sum stays the "
         "same, and stored as a sparse matrix; 0 keeps all, as a dense matrix"},
        {"creases",
         "(edges (k, 2), sharpness (k,) or one number) of a smooth cage: sharp for so many levels; from 10 "
         "on, for all"},
        {"corners", "(vertices (k,), sharpness (k,) or one number) of a smooth cage"}};
    std::ranges::move(described_options<CageSmoothing>(), std::back_inserter(described));
    define_constructor(
        method,
        +[](const Options& given, const SurfaceMesh& cage, const Chosen<WeightPrecision>& precision,
            double threshold, const Chosen<CageSmooth>& smooth, int levels, const OptionalArray& creases,
            const OptionalArray& corners, const Chosen<BoundarySmooth>& boundary_smooth) {
            Options options = given;
            options.weights = {precision.value("precision"), threshold};
            CageSmoothing smoothing;
            smoothing.smooth = smooth.value("smooth");
            smoothing.levels = levels;
            smoothing.boundary_smooth = boundary_smooth.value("boundary_smooth");
            read_creases(creases, corners, smoothing);
            const py::gil_scoped_release unlocked;
            return std::make_shared<Method>(Cage(cage, Method::takes_flat, smoothing), options);
        },
        described,
        "Raises InvalidMesh for a cage that is open, without a volume or inside out; InvalidOption.",
        py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0,
        py::arg("smooth") = "off", py::arg("levels") = 2, py::arg("creases") = py::none(),
        py::arg("corners") = py::none(), py::arg("boundary_smooth") = "all");
    return method;
}

} // namespace sinew::bindings
