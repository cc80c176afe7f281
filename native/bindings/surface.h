// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/core/kept.h"
#include "native/methods/surface/method.h"

#include <memory>
#include <utility>

namespace sinew::bindings {

/// Defines the class of a surface method. The caller adds the constructor and what only this method can do.
template <class Method>
py::class_<Method, SurfaceMethod, std::shared_ptr<Method>>
bind_surface_method(py::module_& module, const char* name, const char* doc)
{
    return {module, name, doc};
}

/// Runs solve(positions) without the GIL, and returns the positions as an array, with the report.
template <class Solve>
py::tuple solved(Solve&& solve)
{
    Points positions;
    SolveReport report;
    {
        const py::gil_scoped_release unlocked;
        report = solve(positions);
        require_finite(positions);
    }
    return py::make_tuple(to_numpy(std::move(positions)), report);
}

/// The same, but unless `out` is None, the positions are written there, rounded to single precision.
template <class Solve>
py::tuple solved(const py::object& out, int vertex_count, Solve&& solve)
{
    if (out.is_none())
        return solved(std::forward<Solve>(solve));
    SinglePoints single = singles(out, "out", vertex_count);
    SolveReport report;
    {
        const py::gil_scoped_release unlocked;
        static Kept<Points> kept; // so that its memory stays mapped from frame to frame
        std::unique_ptr<Points> positions = kept.take();
        report = solve(*positions);
        round_into(*positions, single);
        kept.give_back(std::move(positions));
    }
    return py::make_tuple(out, report);
}

} // namespace sinew::bindings
