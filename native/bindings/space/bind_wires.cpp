// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/methods/space/points/wires.h"

#include <memory>
#include <utility>

namespace sinew::bindings {

namespace {

void bind_wires(py::module_& module)
{
    py::class_<Wires, SpaceMethod, std::shared_ptr<Wires>> wires(
        module, "Wires", R"(Wires [Singh & Fiume 1998], section 5.4: curves carry the space around them.

Points within the radius of a curve follow the nearest place on it, and points outside stay. warp() takes the samples
of the curves now. It costs O(samples + points in reach); memory is 4 bytes per point, and about 72 per point and
curve in whose reach it is.)");
    define_constructor(
        wires,
        +[](const WireOptions& given, const ArrayLike& curves, const OptionalArray& counts) {
            const FloatArray array = floats(curves, "points");
            const Points reference = points<InvalidConstraint>(array, "points");
            WireOptions options = given;
            if (!counts.is_none())
                options.counts = integers(counts, "counts");
            const py::gil_scoped_release unlocked;
            return std::make_shared<Wires>(reference, options);
        },
        {{"points", "(c, 3) samples of the curves at rest, one curve after the other, by parameter"},
         {"counts", "(k,) how many samples each curve has, at least 2; None for a single curve"}},
        "Raises InvalidConstraint for samples that are not finite and for curves without length, "
        "InvalidOption.",
        py::arg("points"), py::arg("counts") = py::none(), py::kw_only());
    wires.def_property_readonly("curve_count", &Wires::curve_count, "Number of curves.")
        .def_property_readonly("sample_count", &Wires::sample_count, "Number of samples of all curves.");
}

const MethodBinding wires_binding(&bind_wires);

} // namespace

} // namespace sinew::bindings
