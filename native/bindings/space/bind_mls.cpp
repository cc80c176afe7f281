// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/choices.h"
#include "native/bindings/handle_points.h"
#include "native/methods/space/nonlinear/mls.h"

#include <array>
#include <string>
#include <vector>

namespace sinew::bindings {

namespace {

std::vector<std::array<int, 2>> mls_segments(const py::object& given)
{
    std::vector<std::array<int, 2>> segments;
    if (given.is_none())
        return segments;
    const std::vector<int> ends = integers(py::module_::import("numpy").attr("ravel")(given), "segments");
    if (ends.size() % 2 != 0)
        throw InvalidConstraint("segments: each has two ends");
    for (std::size_t k = 0; k < ends.size(); k += 2)
        segments.push_back({ends[k], ends[k + 1]});
    return segments;
}

void bind_mls(py::module_& module)
{
    bind_points_method<Mls>(
        module, "Mls",
        R"(Moving least squares [Schaefer, McPhail & Warren 2006, Zhu & Gortler 2007], section 7.

At each point, the map that fits the handles best, near ones the more. A point on a handle goes where the handle takes
it. bind() computes the weights of all handles at each point; a frame fits one map per point.)")
        .def(
            py::init([](const py::object& points, const py::object& counts, const py::object& weights,
                        const std::string& maps, double alpha, const py::object& segments,
                        const std::string& precision) {
                HandlePoints handles = handle_points(points, counts, weights);
                const MlsOptions options{
                    choose<MlsMaps>(maps, "maps",
                                    {{"affine", MlsMaps::affine},
                                     {"similarity", MlsMaps::similarity},
                                     {"rigid", MlsMaps::rigid}}),
                    alpha, mls_segments(segments),
                    choose<WeightPrecision>(precision, "precision",
                                            {{"single", WeightPrecision::single_precision},
                                             {"double", WeightPrecision::double_precision}})};
                const py::gil_scoped_release unlocked;
                return std::make_shared<Mls>(std::move(handles), options);
            }),
            py::arg("points"), py::arg("counts") = py::none(), py::kw_only(), py::arg("weights") = py::none(),
            py::arg("maps") = "rigid", py::arg("alpha") = 2.0, py::arg("segments") = py::none(),
            py::arg("precision") = "single",
            with_handle_points(
                R"(maps       that are fitted: 'rigid', 'similarity' (with one scale), or 'affine', which needs four points that lie in no
           plane; else rigid maps are used, and the report says so.
alpha      > 0, weights are distance^(-2 alpha): the larger, the nearer the handles are that count.
segments   (s, 2) pairs of points that are handles of their own: the segment between them is the handle instead.
precision  of the stored weights: 'single' or 'double'.

Raises InvalidConstraint for points that are not finite or none, counts that do not fit, or a segment without length;
InvalidOption.)")
                .c_str())
        .def_property_readonly(
            "maps",
            [](const Mls& method) {
                return method.maps() == MlsMaps::affine       ? "affine"
                       : method.maps() == MlsMaps::similarity ? "similarity"
                                                              : "rigid";
            },
            "The maps that are fitted: 'affine', 'similarity' or 'rigid'.");
}

const MethodBinding mls_binding(&bind_mls);

} // namespace

} // namespace sinew::bindings
