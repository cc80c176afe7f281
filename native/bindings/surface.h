// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/core/system/kept.h"
#include "native/methods/surface/method.h"

#include <memory>
#include <utility>
#include <vector>

namespace sinew::bindings {

/// The class of a surface method, without a constructor.
template <class Method>
using SurfaceClass = py::class_<Method, SurfaceMethod, std::shared_ptr<Method>>;

/// Defines the class of a surface method that is made of a mesh and its options. The caller adds what only
/// this method can do.
/// \param raises  the end of the constructor's documentation.
template <class Method>
SurfaceClass<Method> bind_surface_method(py::module_& module, const char* name, const char* doc,
                                         const char* raises = "Raises InvalidOption.")
{
    SurfaceClass<Method> method(module, name, doc);
    define_constructor(
        method,
        +[](const typename Method::Options& options, const SurfaceMesh& mesh) {
            const py::gil_scoped_release unlocked;
            return std::make_shared<Method>(mesh, options);
        },
        {{"mesh", "SurfaceMesh, the rest shape"}}, raises, py::arg("mesh"), py::kw_only());
    return method;
}

/// What a method says of each vertex, or some vertices: found without the GIL.
template <class Method>
auto numbers_of(std::vector<int> (Method::*find)() const)
{
    return [find](const Method& method) {
        std::vector<int> found;
        {
            const py::gil_scoped_release unlocked;
            found = (method.*find)();
        }
        return to_numpy(found);
    };
}

/// The energy of given points, found without the GIL.
template <class Method>
double energy_of(const Method& method, const ArrayLike& positions)
{
    const FloatArray array = floats(positions, "positions");
    const PointsView view = points<InvalidConstraint>(array, "positions");
    const py::gil_scoped_release unlocked;
    return method.energy(view);
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
py::tuple solved(const Out& out, int vertex_count, Solve&& solve)
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
