// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/representation.h"
#include "native/bindings/surface.h"
#include "native/methods/surface/nonlinear/mesh_sequence.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

constexpr int key_numbers = 14; ///< frame, handle, and the (3, 4) map row by row

/// None, or (m, 14).
EditKeys keys_of(const ArrayLike& object)
{
    if (object.is_none())
        return {};
    const FloatArray array = floats(object, "keys");
    if (array.size() == 0)
        return {};
    if (array.ndim() != 2 || array.shape(1) != key_numbers)
        throw InvalidOption("keys: the shape must be (m, 14): frame, handle and twelve numbers of a map");
    std::vector<EditKey> keys;
    for (py::ssize_t k = 0; k < array.shape(0); ++k) {
        const double* row = array.data() + key_numbers * k;
        const bool whole = row[1] >= 0 && row[1] <= 1e9 && row[1] == static_cast<int>(row[1]);
        keys.push_back({row[0], whole ? static_cast<int>(row[1]) : -1, Eigen::Map<const Pose>(row + 2)});
    }
    return EditKeys(keys);
}

py::array_t<double> array_of(const Poses& poses)
{
    py::array_t<double> array({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}, py::ssize_t{4}});
    for (std::size_t h = 0; h < poses.size(); ++h)
        std::copy_n(poses[h].data(), 12, array.mutable_data() + 12 * h);
    return array;
}

/// The identity for each handle.
Poses unmoved(const MeshSequence& method)
{
    const py::gil_scoped_release unlocked;
    const AccessLock shared = method.reading();
    return Poses(method.regions().handle_count(), Pose(Pose::Identity()));
}

/// The arguments that all calls about one frame share, kept alive for the request that views them.
struct Asked
{
    /// \param poses  None for controls at rest.
    Asked(const MeshSequence& method, const ArrayLike& poses, const OptionalArray& incoming,
          const OptionalFlags& from_rest)
        : entering(incoming, "incoming")
    {
        request.poses = poses.is_none() ? unmoved(method) : bindings::poses(poses);
        request.from_rest = flags(from_rest, request.poses.size());
        if (entering.view)
            request.incoming.emplace(*entering.view);
    }

    OptionalPoints entering;
    SolveRequest request;
};

Solved solve_frame(const MeshSequence& method, double frame, const ArrayLike& poses,
                   const OptionalArray& keys, const OptionalArray& incoming, const OptionalFlags& from_rest,
                   const OptionalArray& start, std::optional<int> max_iterations,
                   std::optional<double> tolerance, const Callback& callback, const Out& out)
{
    Asked asked(method, poses, incoming, from_rest);
    const OptionalPoints first(start, "start");
    const EditKeys edits = keys_of(keys);
    if (first.view)
        asked.request.start.emplace(*first.view);
    asked.request.max_iterations = max_iterations;
    asked.request.tolerance = tolerance;
    asked.request.progress = progress(callback);
    return solved(out, method.rest().vertex_count(), [&](Points& positions) {
        return method.solve_frame(frame, edits, asked.request, positions);
    });
}

/// Where shape `place` is in an array (f, n, 3).
PointsView shape_in(const FloatArray& shapes, py::ssize_t place)
{
    return {shapes.data() + place * shapes.shape(1) * 3, shapes.shape(1), 3};
}

py::tuple solve_frames(const MeshSequence& method, const ArrayLike& frames, const ArrayLike& shapes,
                       const OptionalArray& keys, const ArrayLike& poses, const OptionalFlags& from_rest,
                       std::optional<int> max_iterations, std::optional<double> tolerance,
                       const Callback& callback)
{
    const std::vector<double> numbers = bindings::numbers(frames, "frames");
    const FloatArray entering = floats(shapes, "shapes");
    if (entering.ndim() != 3 || entering.shape(2) != 3)
        throw InvalidConstraint("shapes: the shape must be (f, n, 3), one shape per frame");
    const EditKeys edits = keys_of(keys);
    SolveRequest request;
    request.poses = poses.is_none() ? unmoved(method) : bindings::poses(poses);
    request.from_rest = flags(from_rest, request.poses.size());
    request.max_iterations = max_iterations;
    request.tolerance = tolerance;
    request.progress = progress(callback);
    std::vector<PointsView> views;
    for (py::ssize_t k = 0; k < entering.shape(0); ++k)
        views.push_back(shape_in(entering, k));
    const py::ssize_t count = method.rest().vertex_count();
    py::array_t<double> result({static_cast<py::ssize_t>(numbers.size()), count, py::ssize_t{3}});
    double* const first = result.mutable_data();
    std::vector<SolveReport> reports;
    {
        const py::gil_scoped_release unlocked;
        reports = method.solve_frames(numbers, edits, views, request, [&](int place, Points& positions) {
            require_finite(positions);
            std::copy_n(positions.data(), positions.size(),
                        first + static_cast<py::ssize_t>(place) * count * 3);
        });
    }
    return py::make_tuple(result, reports);
}

/// Runs call(keys, request) without the GIL.
template <class Call>
py::array_t<double> maps(const MeshSequence& method, const ArrayLike& poses, const OptionalArray& keys,
                         const OptionalArray& incoming, const OptionalFlags& from_rest, Call&& call)
{
    const Asked asked(method, poses, incoming, from_rest);
    const EditKeys edits = keys_of(keys);
    Poses found;
    {
        const py::gil_scoped_release unlocked;
        found = call(edits, asked.request);
    }
    return array_of(found);
}

void bind_mesh_sequence(py::module_& module)
{
    py::class_<EditKeys>(module, "EditKeys", R"(Keys of the edits of handles, and the edits between them.

An edit is an affine map in the moving frame of a handle, whose origin is its centre. Between keys its move, its turn
and its stretch run along cubic curves that are C1 and never exceed the keys. Before the first key of a handle and after
its last one the edit stays as it is there; a handle without keys is not edited.)")
        .def(py::init([](const OptionalArray& keys) { return keys_of(keys); }), py::arg("keys"), R"(
keys  (m, 14), in any order: frame, handle, and the map (3, 4) row by row.

Raises InvalidOption for two keys of a handle at one frame, or a number that is not finite.)")
        .def(
            "at",
            [](const EditKeys& keys, int handle, double frame) {
                return array_of({keys.at(handle, frame)}).attr("reshape")(3, 4);
            },
            py::arg("handle"), py::arg("frame"), "The edit of a handle at a frame -> (3, 4).")
        .def_property_readonly("handle_count", &EditKeys::handle_count,
                               "The last handle that has a key, plus one.")
        .def("__repr__", [](const py::object& self) {
            return representation(self,
                                  std::to_string(self.cast<const EditKeys&>().handle_count()) + " handles");
        });

    bind_surface_method<MeshSequence>(module, "MeshSequence",
                                      R"(Edits of an animated mesh [Xu et al. 2007], tutorial section 6.

Handles are edited at keys, in frames that move with them through the animation. Each frame is solved by itself, as by
Arap with the shape of the animation as the incoming one: it depends on its number, that shape and the keys alone. A
frame without an edit is reproduced. set_handles() costs what that of Arap costs, once for all frames.)")
        .def("solve_frame", &solve_frame, py::arg("frame"), py::kw_only(), py::arg("poses") = py::none(),
             py::arg("keys") = py::none(), py::arg("incoming") = py::none(),
             py::arg("from_rest") = py::none(), py::arg("start") = py::none(),
             py::arg("max_iterations") = py::none(), py::arg("tolerance") = py::none(),
             py::arg("progress") = py::none(), py::arg("out") = py::none(),
             R"(One frame of the edited animation -> (positions (n, 3), SolveReport). No factorisation.

frame      its number.
poses      None, or (k, 3, 4) maps of controls, which edit beside the keys: each turns and scales its handle about the
           handle's centre, and moves it as far as it moves that centre at rest.
keys       None, or (m, 14) as EditKeys takes them.
incoming   (n, 3) the animation in this frame; None for the rest shape.
from_rest  None, a flag, or (k,) flags: the handles whose control follows the animation, so that only what its
           pose does beyond the moving frame edits.

The others are those of solve(). Raises InvalidConstraint, InvalidOption or Cancelled.)")
        .def("solve_frames", &solve_frames, py::arg("frames"), py::arg("shapes"), py::kw_only(),
             py::arg("keys") = py::none(), py::arg("poses") = py::none(), py::arg("from_rest") = py::none(),
             py::arg("max_iterations") = py::none(), py::arg("tolerance") = py::none(),
             py::arg("progress") = py::none(),
             R"(Many frames, several at once -> (positions (f, n, 3), [SolveReport]).

frames  (f,) their numbers.
shapes  (f, n, 3) the animation in these frames.
keys    None, or (m, 14) as EditKeys takes them.
poses   None, or (k, 3, 4): the edits beside the keys, the same in all frames; see solve_frame().

Each frame has the same bits as by solve_frame(). Raises InvalidOption, InvalidConstraint, which names the frame, or
Cancelled.)")
        .def(
            "edits",
            [](const MeshSequence& method, double frame, const ArrayLike& poses, const OptionalArray& keys,
               const OptionalArray& incoming, const OptionalFlags& from_rest) {
                return maps(method, poses, keys, incoming, from_rest,
                            [&](const EditKeys& edits, const SolveRequest& request) {
                                return method.edits(frame, edits, request);
                            });
            },
            py::arg("frame"), py::kw_only(), py::arg("poses") = py::none(), py::arg("keys") = py::none(),
            py::arg("incoming") = py::none(), py::arg("from_rest") = py::none(),
            R"(The whole edits in a frame, by keys and poses -> (k, 3, 4): what a key at this frame holds.

The arguments are those of solve_frame(). Raises InvalidConstraint or InvalidOption.)")
        .def(
            "poses",
            [](const MeshSequence& method, double frame, const ArrayLike& poses, const OptionalArray& keys,
               const OptionalArray& incoming, const OptionalFlags& from_rest) {
                return maps(method, poses, keys, incoming, from_rest,
                            [&](const EditKeys& edits, const SolveRequest& request) {
                                return method.poses(frame, edits, request);
                            });
            },
            py::arg("frame"), py::kw_only(), py::arg("poses") = py::none(), py::arg("keys") = py::none(),
            py::arg("incoming") = py::none(), py::arg("from_rest") = py::none(),
            R"(How a frame moves the incoming points of the handles, in object space -> (k, 3, 4).

The arguments are those of solve_frame(). Raises InvalidConstraint or InvalidOption.)")
        .def(
            "still_poses",
            [](const MeshSequence& method, const OptionalArray& incoming, const OptionalFlags& from_rest) {
                return maps(method, py::none(), py::none(), incoming, from_rest,
                            [&](const EditKeys&, const SolveRequest& request) {
                                return method.still_poses(request);
                            });
            },
            py::kw_only(), py::arg("incoming") = py::none(), py::arg("from_rest") = py::none(),
            R"(The poses that edit nothing -> (k, 3, 4): the identity, or with from_rest the moving frame.

The arguments are those of solve_frame(). Raises InvalidConstraint.)")
        .def("energy", &energy_of<MeshSequence>, py::arg("positions"),
             R"(Energy of given points, with the rest shape as its base, as that of Arap -> a number.

positions  (n, 3).

Raises InvalidConstraint for another shape or a number that is not finite.)");
}

const MethodBinding mesh_sequence_binding(&bind_mesh_sequence);

} // namespace

} // namespace sinew::bindings
