// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_methods.h"
#include "native/bindings/representation.h"
#include "native/bindings/warped.h"

#include <algorithm>
#include <optional>

namespace sinew::bindings {

namespace {

Singles warp_poses(const HandleMethod& method, const ArrayLike& given, const Out& out,
                   const OptionalArray& incoming, const OptionalFlags& from_rest)
{
    const Poses maps = poses(given);
    const std::vector<bool> aims = flags(from_rest, maps.size()).value_or(std::vector<bool>{});
    const OptionalPoints entering(incoming, "incoming");
    return warped(method, out, [&](PositionsOut positions, std::optional<Eigen::Index> room) {
        method.warp_poses(maps, entering.view, positions, room, aims);
    });
}

py::tuple network(const HandleMethod& method, const ArrayLike& given, const OptionalArray& incoming,
                  const OptionalFlags& from_rest)
{
    const Poses maps = poses(given);
    const std::vector<bool> aims = flags(from_rest, maps.size()).value_or(std::vector<bool>{});
    const OptionalPoints entering(incoming, "incoming");
    HandleMethod::Network found;
    {
        const py::gil_scoped_release unlocked;
        found = method.network(maps, entering.view, aims);
    }
    return py::make_tuple(to_numpy(std::move(found.nodes)), pairs(found.links));
}

SolveReport report_for(const HandleMethod& method, const ArrayLike& given)
{
    const Poses maps = poses(given);
    const py::gil_scoped_release unlocked;
    return method.report_for(maps);
}

} // namespace

py::array_t<int> pairs(const std::vector<std::array<int, 2>>& list)
{
    py::array_t<int> result({static_cast<py::ssize_t>(list.size()), py::ssize_t{2}});
    if (!list.empty())
        std::copy_n(list.front().data(), 2 * list.size(), result.mutable_data());
    return result;
}

void bind_handle_methods(py::module_& module)
{
    py::class_<HandleMethod, SpaceMethod, std::shared_ptr<HandleMethod>>(
        module, "HandleMethod", R"(What every deformation of space that handles move can do.

warp() takes the posed points of the handles, (c, 3), and fits a motion to those of each handle: affine, rigid where
they lie on a plane or a line, and a translation for a single point. warp_poses() takes the motions themselves.)")
        .def("warp_poses", &warp_poses, py::arg("poses"), py::arg("out") = py::none(), py::kw_only(),
             py::arg("incoming") = py::none(), py::arg("from_rest") = py::none(),
             R"(Where posed handles move the bound points -> (n, 3).

poses      (k, 3, 4) affine map of each handle in object space, from its rest to its posed state.
out        None, or a writable C-contiguous (n, 3) float32 array to write into, which is returned.
incoming   (n, 3) the shape to deform in this frame; None for the bound points.
from_rest  None (False), one flag or one per handle: whether its pose applies to the rest shape, because its
           control moves along with what has deformed the incoming shape.

Handles at rest give exactly the incoming shape. The answer depends on the arguments alone.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, two handles that take one point to
two places, or before bind().)")
        .def("network", &network, py::arg("poses"), py::kw_only(), py::arg("incoming") = py::none(),
             py::arg("from_rest") = py::none(),
             R"(What moves the points between the handles -> (m, 3) nodes, (l, 2) pairs that hold together.

poses  (k, 3, 4); this, incoming and from_rest as in warp_poses().

Raises InvalidConstraint as warp_poses().)")
        .def("report_for", &report_for, py::arg("poses"),
             R"(What a warp of the bound points to poses reaches -> SolveReport.

poses  (k, 3, 4). Raises InvalidConstraint as warp_poses().)")
        .def("__repr__", [](const py::object& self) {
            const int count = self.cast<const HandleMethod&>().handles().count();
            return representation(self, std::to_string(count) + (count == 1 ? " handle" : " handles"));
        });
}

} // namespace sinew::bindings
