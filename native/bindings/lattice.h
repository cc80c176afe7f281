// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/choices.h"
#include "native/bindings/representation.h"
#include "native/methods/space/lattice/ffd.h"

#include <pybind11/stl.h>

#include <array>
#include <string>

namespace sinew::bindings {

/// One count for all axes, or one per axis.
inline std::array<int, 3> three_counts(const ArrayLike& given, const char* name)
{
    std::array<int, 3> counts;
    if (py::isinstance<py::int_>(given)) {
        counts.fill(given.cast<int>());
        return counts;
    }
    const std::vector<int> each = integers(given, name);
    if (each.size() != 3)
        throw InvalidOption(std::string(name) + ": give one number per axis, not " +
                            std::to_string(each.size()));
    return {each[0], each[1], each[2]};
}

/// \param blender  whether 'blender' is a choice, too, which the caller has dealt with.
inline LatticeBasis spline_or_bezier(const std::string& basis, bool blender)
{
    return blender
               ? choose<LatticeBasis>(basis, "basis",
                                      {{"bspline", LatticeBasis::bspline},
                                       {"bezier", LatticeBasis::bezier},
                                       {"blender", LatticeBasis::blender_spline}})
               : choose<LatticeBasis>(basis, "basis",
                                      {{"bspline", LatticeBasis::bspline}, {"bezier", LatticeBasis::bezier}});
}

} // namespace sinew::bindings
