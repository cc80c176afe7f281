// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/points/wires.h"

#include <memory>
#include <utility>

namespace sinew::bindings {

namespace {

std::shared_ptr<Wires> make_wires(const py::object& curves, const py::object& counts,
                                  const py::object& closed, const py::object& radius, const py::object& scale,
                                  const py::object& rotation, const py::object& domain, double exponent,
                                  double smoothing)
{
    const FloatArray array = floats(curves, "points");
    const Points reference = points<InvalidConstraint>(array, "points");
    const OptionalPoints limits(domain, "domain");
    WireOptions options{.counts = counts.is_none() ? std::vector<int>{} : integers(counts, "counts"),
                        .closed = flags(closed, 1, "closed").value_or(std::vector<bool>{}),
                        .radius = numbers(radius, "radius"),
                        .scale = numbers(scale, "scale"),
                        .rotation = numbers(rotation, "rotation"),
                        .domain = limits.view ? Points(*limits.view) : Points(),
                        .exponent = exponent,
                        .smoothing = smoothing};
    const py::gil_scoped_release unlocked;
    return std::make_shared<Wires>(reference, options);
}

void bind_wires(py::module_& module)
{
    py::class_<Wires, SpaceMethod, std::shared_ptr<Wires>>(
        module, "Wires", R"(Wires [Singh & Fiume 1998], section 5.4: curves carry the space around them.

Points within the radius of a curve follow the nearest place on it, and points outside stay. warp() takes the samples
of the curves now. It costs O(samples + points in reach); memory is 4 bytes per point, and about 72 per point and
curve in whose reach it is.)")
        .def(py::init(&make_wires), py::arg("points"), py::arg("counts") = py::none(), py::kw_only(),
             py::arg("closed") = py::none(), py::arg("radius") = 1.0, py::arg("scale") = 1.0,
             py::arg("rotation") = 1.0, py::arg("domain") = py::none(), py::arg("exponent") = 1.0,
             py::arg("smoothing") = 0.2, R"(
points     (c, 3) samples of the curves at rest, one curve after the other, by parameter.
counts     (k,) how many samples each curve has, at least 2; None for a single curve.
closed     None, a flag, or (k,) flags: the curves whose last sample is joined to the first.
radius     > 0, a number or (k,): how far from the curve points follow it.
scale      a number or (k,): of the distances from the curve, near the curve; it acts at rest, too.
rotation   in [0, 1], a number or (k,): how much of the turn of the curve points follow.
domain     None, or (c, 3) samples of domain curves, NaN for curves without one: in the direction of its
           domain curve, a wire reaches as far as that.
exponent   >= 0: of several wires, those with a longer move prevail the more, the larger it is.
smoothing  >= 0: how much farther than the nearest place of a curve others count, as a share; with 0 only the
           nearest counts, and the warp jumps where that jumps.

Raises InvalidConstraint for samples that are not finite and for curves without length, InvalidOption.)")
        .def_property_readonly("curve_count", &Wires::curve_count, "Number of curves.")
        .def_property_readonly("sample_count", &Wires::sample_count, "Number of samples of all curves.");
}

const MethodBinding wires_binding(&bind_wires);

} // namespace

} // namespace sinew::bindings
