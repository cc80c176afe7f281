// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_points.h"
#include "native/methods/space/points/rbf.h"

#include <string>

namespace sinew::bindings {

namespace {

void bind_rbf(py::module_& module)
{
    bind_points_method<Rbf, RbfOptions>(
        module, "Rbf",
        R"(Radial basis functions [Duchon 1977, Botsch & Kobbelt 2005], section 5.3.

The smoothest deformation of space that takes the points of the handles along. bind() solves one system; a frame of
handles of several points is a product with 4 functions per handle, and that of single points a sum over all of them.)")
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
