// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/choices.h"
#include "native/methods/surface/nonlinear/arap.h"

#include <string>

namespace sinew::bindings {

/// The options of Arap, and of methods that are made of it, from the arguments in Python.
inline ArapOptions arap_options(double smoothness, const std::string& cells, const py::object& rigidity,
                                int max_iterations, double tolerance, double point_handles)
{
    ArapOptions options;
    options.smoothness = smoothness;
    options.cells = choose<ArapOptions::Cells>(
        cells, "cells", {{"spokes", ArapOptions::Cells::spokes}, {"rims", ArapOptions::Cells::rims}});
    options.rigidity = numbers(rigidity, "rigidity");
    options.max_iterations = max_iterations;
    options.tolerance = tolerance;
    options.point_handles = point_handles;
    return options;
}

} // namespace sinew::bindings
