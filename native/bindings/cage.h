// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/choices.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/cage_coordinates.h"

#include <memory>
#include <string>
#include <utility>

namespace sinew::bindings {

inline PointWeightOptions weight_options(const std::string& precision, double threshold)
{
    return {choose<WeightPrecision>(precision, "precision",
                                    {{"single", WeightPrecision::single_precision},
                                     {"double", WeightPrecision::double_precision}}),
            threshold};
}

inline CageOutside cage_outside(const std::string& outside)
{
    return choose<CageOutside>(outside, "outside",
                               {{"error", CageOutside::refuse}, {"mean_value", CageOutside::mean_value}});
}

/// Calls a member function that reads what a bind made. Another thread may bind now: the GIL is free while
/// this one waits.
template <auto member, class Method>
auto read(const Method& method)
{
    const py::gil_scoped_release unlocked;
    const AccessLock shared = method.reading();
    return (method.*member)();
}

/// Defines the class of a cage method and its constructor, which takes the arguments that all cage methods
/// have and then its own. The caller adds what only this method can do.
/// \param options  makes the method's options from those of the weights and its own arguments.
/// \param words    documentation of its own arguments.
/// \param own      py::arg(...) = default for each of its own arguments.
template <class Method, class Options, class... Own, class... Words>
py::class_<Method, CageCoordinates, std::shared_ptr<Method>>
bind_cage_method(py::module_& module, const char* name, const char* doc,
                 Options (*options)(const PointWeightOptions&, Own...), const std::string& words,
                 Words&&... own)
{
    py::class_<Method, CageCoordinates, std::shared_ptr<Method>> result(module, name, doc);
    const std::string text = R"(
cage        SurfaceMesh, the closed rest cage, with faces that look outwards)" +
                             std::string(Method::takes_flat ? ", or one in a plane: its outline counts"
                                                            : "") +
                             R"(.
precision   of the weights: 'single' (half the memory and time of a warp) or 'double'.
threshold   weights of a smaller magnitude are dropped, the others are changed so that their sum stays
            the same, and stored as a sparse matrix; 0 keeps all, as a dense matrix.
)" + words + R"(
Raises InvalidMesh for a cage that is open, without a volume or inside out; InvalidOption.)";
    result.def(py::init([options](const SurfaceMesh& cage, const std::string& precision, double threshold,
                                  Own... values) {
                   const Options chosen = options(weight_options(precision, threshold), values...);
                   const py::gil_scoped_release unlocked;
                   return std::make_shared<Method>(Cage(cage, Method::takes_flat), chosen);
               }),
               py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0,
               std::forward<Words>(own)..., text.c_str());
    return result;
}

} // namespace sinew::bindings
