// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/handle_points.h"
#include "native/methods/space/points/rbf.h"

#include <string>

namespace sinew::bindings {

namespace {

void bind_rbf(py::module_& module)
{
    bind_points_method<Rbf>(module, "Rbf",
                            R"(Radial basis functions [Duchon 1977, Botsch & Kobbelt 2005], section 5.3.

The smoothest deformation of space that takes the points of the handles along. bind() solves one system; a frame of
handles of several points is a product with 4 functions per handle, and that of single points a sum over all of them.)")
        .def(
            py::init([](const py::object& points, const py::object& counts, const py::object& weights,
                        const std::string& kernel, int degree, double radius, double tolerance,
                        const std::string& precision) {
                HandlePoints handles = handle_points(points, counts, weights);
                const RbfOptions options{
                    choose<RbfFunction>(kernel, "kernel",
                                        {{"triharmonic", RbfFunction::triharmonic},
                                         {"biharmonic", RbfFunction::biharmonic},
                                         {"wendland_c0", RbfFunction::wendland_c0},
                                         {"wendland_c2", RbfFunction::wendland_c2},
                                         {"wendland_c4", RbfFunction::wendland_c4}}),
                    degree, radius, tolerance,
                    choose<WeightPrecision>(precision, "precision",
                                            {{"single", WeightPrecision::single_precision},
                                             {"double", WeightPrecision::double_precision}})};
                const py::gil_scoped_release unlocked;
                return std::make_shared<Rbf>(std::move(handles), options);
            }),
            py::arg("points"), py::arg("counts") = py::none(), py::kw_only(), py::arg("weights") = py::none(),
            py::arg("kernel") = "triharmonic", py::arg("degree") = 2, py::arg("radius") = 0.5,
            py::arg("tolerance") = 1e-4, py::arg("precision") = "single",
            with_handle_points(
                R"(kernel     'triharmonic' (r^3, the smoothest), 'biharmonic' (-r), or a compact one: 'wendland_c0', 'wendland_c2' or
           'wendland_c4'.
degree     -1 to 2, of the polynomials that are reproduced. The triharmonic kernel uses at least 1, the biharmonic one
           0 or 1, compact ones at most 1. With -1, a compact kernel leaves points beyond its radius at rest.
radius     >= 1e-9, of a compact kernel, as a share of the diameter() of all points.
tolerance  >= 0. If there are many points, handles of several are met up to this share of the longest move of the
           control, with as few centres as that takes; 0 meets all exactly.
precision  of the functions of handles of several points: 'single' or 'double'.

Raises InvalidConstraint for points that are not finite or none, or counts that do not fit; InvalidOption.)")
                .c_str())
        .def_property_readonly(
            "centres",
            [](const Rbf& method) {
                Points centres;
                {
                    const py::gil_scoped_release unlocked;
                    centres = method.centres();
                }
                return to_numpy(std::move(centres));
            },
            "(c, 3) the centres of the radial functions; none before bind().");
}

const MethodBinding rbf_binding(&bind_rbf);

} // namespace

} // namespace sinew::bindings
