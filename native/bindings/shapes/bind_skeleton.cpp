// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/representation.h"
#include "native/core/errors.h"
#include "native/skeleton/bone_regions.h"
#include "native/skeleton/pose_solver.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

using BoneMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// (k, 3, 3) -> matrices.
std::vector<Matrix3> bone_rotations(const ArrayLike& object, const char* name)
{
    const FloatArray array = floats(object, name);
    if (array.size() == 0)
        return {};
    if (array.ndim() != 3 || array.shape(1) != 3 || array.shape(2) != 3)
        throw InvalidConstraint(std::string(name) + ": the shape must be (k, 3, 3), one matrix per bone");
    std::vector<Matrix3> result(array.shape(0));
    for (std::size_t b = 0; b < result.size(); ++b)
        result[b] = Eigen::Map<const BoneMatrix>(array.data() + 9 * b);
    return result;
}

Points bone_points(const ArrayLike& object, const char* name)
{
    const FloatArray array = floats(object, name);
    return points<InvalidConstraint>(array, name);
}

Vector3 bone_vector(const ArrayLike& object, const char* name)
{
    const FloatArray array = floats(object, name);
    if (array.ndim() != 1 || array.shape(0) != 3)
        throw InvalidConstraint(std::string(name) + ": the shape must be (3,)");
    return Vector3::Map(array.data());
}

std::vector<Joint> joints_of_bones(int bones, const OptionalArray& most, const OptionalArray& angles,
                                   const OptionalArray& stiffness)
{
    std::vector<Joint> all(bones);
    const auto each = [&](const ArrayLike& object, const char* name, auto&& set) {
        if (object.is_none())
            return;
        const std::vector<double> values = numbers(object, name);
        if (values.size() != 1 && values.size() != all.size())
            throw InvalidConstraint(std::string(name) + ": give one number, or one per bone");
        for (int b = 0; b < bones; ++b)
            set(all[b], values[values.size() == 1 ? 0 : b]);
    };
    each(most, "most", [](Joint& joint, double value) { joint.most = value; });
    each(stiffness, "stiffness", [](Joint& joint, double value) { joint.stiffness = value; });
    if (angles.is_none())
        return all;
    for (const auto item : angles.cast<py::dict>()) {
        const int bone = item.first.cast<int>();
        if (bone < 0 || bone >= bones)
            throw InvalidConstraint("angles: there is no bone " + std::to_string(bone));
        const auto given = py::reinterpret_borrow<py::tuple>(item.second);
        if (!py::isinstance<py::tuple>(item.second) || given.size() != 3)
            throw py::type_error("angles: each entry is a tuple of the lower angles, the upper ones and an "
                                 "order such as 'XYZ'");
        Joint& joint = all[bone];
        joint.kind = Joint::Kind::angles;
        joint.lower = bone_vector(given[0], "the lower angles");
        joint.upper = bone_vector(given[1], "the upper angles");
        const auto order = given[2].cast<std::string>();
        for (int k = 0; k < 3; ++k) {
            const std::size_t axis =
                order.size() == 3 ? std::string("XYZ").find(order[k]) : std::string::npos;
            if (axis == std::string::npos)
                throw InvalidOption("angles: the order '" + order +
                                    "' is not one of three axes, as in 'XYZ'");
            joint.order[k] = static_cast<int>(axis);
        }
    }
    return all;
}

std::shared_ptr<Skeleton> make_skeleton(const ArrayLike& heads, const ArrayLike& tails,
                                        const ArrayLike& parents, const ArrayLike& axes,
                                        const OptionalArray& most, const OptionalArray& angles,
                                        const OptionalArray& stiffness)
{
    std::vector<int> earlier = integers(parents, "parents");
    std::vector<Joint> limits = joints_of_bones(static_cast<int>(earlier.size()), most, angles, stiffness);
    return std::make_shared<Skeleton>(
        bone_points(heads, "heads"), bone_points(tails, "tails"), std::move(earlier),
        axes.is_none() ? std::vector<Matrix3>() : bone_rotations(axes, "axes"), std::move(limits));
}

Posture posture_of(const Skeleton& skeleton, const OptionalArray& turns, const ArrayLike& moves)
{
    Posture posture = skeleton.rest();
    if (!turns.is_none())
        posture.turns = bone_points(turns, "turns");
    if (!moves.is_none())
        posture.moves = bone_points(moves, "moves");
    skeleton.check(posture);
    return posture;
}

py::array_t<double> rotation_array(const std::vector<Matrix3>& matrices)
{
    py::array_t<double> array({static_cast<py::ssize_t>(matrices.size()), py::ssize_t{3}, py::ssize_t{3}});
    for (std::size_t b = 0; b < matrices.size(); ++b)
        Eigen::Map<BoneMatrix>(array.mutable_data() + 9 * b) = matrices[b];
    return array;
}

py::array_t<double> pose_array(const Poses& poses)
{
    py::array_t<double> array({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}, py::ssize_t{4}});
    for (std::size_t b = 0; b < poses.size(); ++b)
        Eigen::Map<Pose>(array.mutable_data() + 12 * b) = poses[b];
    return array;
}

std::vector<bool> bone_flags(const ArrayLike& object, int bones)
{
    return flags(object, bones).value_or(std::vector<bool>());
}

py::tuple solve_skeleton(const Skeleton& skeleton, const ArrayLike& bones, const OptionalArray& places,
                         const OptionalArray& goals, const OptionalArray& weights, const OptionalArray& turns,
                         const ArrayLike& moves, const OptionalArray& moving_roots,
                         const OptionalArray& locked, const OptionalArray& support, const OptionalArray& up,
                         const OptionalArray& masses, const OptionalArray& centres,
                         const PoseSolverOptions& options)
{
    PoseRequest request;
    const std::vector<int> indices = integers(bones, "bones");
    const Points from = bone_points(places, "points"), to = bone_points(goals, "goals");
    std::vector<double> firm(indices.size(), 1.0);
    if (!weights.is_none())
        firm = numbers(weights, "weights");
    if (from.rows() != static_cast<Eigen::Index>(indices.size()) || to.rows() != from.rows() ||
        firm.size() != indices.size())
        throw InvalidConstraint("the numbers of bones, points, goals and weights differ");
    for (std::size_t t = 0; t < indices.size(); ++t) {
        const auto row = static_cast<Eigen::Index>(t);
        request.targets.push_back({indices[t], from.row(row), to.row(row), firm[t]});
    }
    request.base = posture_of(skeleton, turns, moves);
    request.moving_roots = bone_flags(moving_roots, skeleton.bone_count());
    request.locked = bone_flags(locked, skeleton.bone_count());
    if (!support.is_none()) {
        Balance& balance = request.balance.emplace();
        balance.support = bone_points(support, "support");
        balance.up = up.is_none() ? Vector3(0, 0, 1) : bone_vector(up, "up");
        if (!masses.is_none())
            balance.masses = numbers(masses, "masses");
        if (!centres.is_none())
            balance.centres = bone_points(centres, "centres");
    }
    Posture posture;
    PoseReport report;
    {
        const py::gil_scoped_release unlocked;
        report = solve_pose(skeleton, request, posture, options);
    }
    return py::make_tuple(to_numpy(std::move(posture.turns)), to_numpy(std::move(posture.moves)), report);
}

void bind_skeleton(py::module_& module)
{
    py::class_<PoseReport>(module, "PoseReport", "What Skeleton.solve() reached.")
        .def_readonly("iterations", &PoseReport::iterations, "Number of accepted steps.")
        .def_readonly("rejected", &PoseReport::rejected, "Number of trial steps that were not accepted.")
        .def_readonly("energy", &PoseReport::energy, "F of the class.")
        .def_readonly("converged", &PoseReport::converged,
                      "Whether the tolerance was met before the iterations were used up.")
        .def_property_readonly(
            "gaps", [](const PoseReport& report) { return to_numpy(report.gaps); },
            "(t,) how far from their goals the points are.")
        .def_property_readonly(
            "centre",
            [](const PoseReport& report) {
                return py::array_t<double>(py::ssize_t{3}, report.centre.data());
            },
            "(3,) the centre of mass, if there is a support.")
        .def_readonly("overhang", &PoseReport::overhang,
                      "How far that is outside of the support, at least 0.")
        .def("__repr__", [](const PoseReport& report) {
            return "<PoseReport: " + std::to_string(report.iterations) + " iterations>";
        });

    py::class_<Skeleton, std::shared_ptr<Skeleton>>(module, "Skeleton",
                                                    R"(Bones of fixed lengths, each turning about its head.

Its posture is turns (k, 3), of each bone against its parent, and moves (k, 3), of bones without a parent. Turns are
rotation vectors in the bone's own axes, or, for bones in `angles`, angles about x, y and z. Zeros are the rest.
solve() minimises F = sum_t w_t |p_t - g_t|^2 / (2 size^2) + rest / 2 sum_b stiffness_b |turn_b - base_b|^2 within
limits [Shi et al. 2007], where size is the diagonal of the box around all bones. A joint without limits by which alone
its limb goes on, such as a knee, has a hinge across its bend at rest: what turns aside of that counts 1 + swing times.
It never changes, and any number of threads may use it.)")
        .def(py::init(&make_skeleton), py::arg("heads"), py::arg("tails"), py::arg("parents"), py::kw_only(),
             py::arg("axes") = py::none(), py::arg("most") = py::none(), py::arg("angles") = py::none(),
             py::arg("stiffness") = py::none(), R"(
heads, tails  (k, 3) where the bones are at rest.
parents       (k,) indices of earlier bones, or -1.
axes          (k, 3, 3) rotations whose columns are the bones' own axes at rest; None for axes of which y runs
              along the bone.
most          None, a number or (k,) numbers >= 0: by how much each bone turns at most, in radians. 0 locks it.
angles        None, or a dict of bones that turn by angles instead: {bone: (lower (3,), upper (3,), 'XYZ')}, in
              radians about the bone's own x, y and z, the first axis of the order turned about first.
stiffness     None (1), a number or (k,) numbers > 0: how firmly each joint stays as it is.

Raises InvalidConstraint or InvalidOption, which names a bone.)")
        .def_property_readonly("bone_count", &Skeleton::bone_count, "k")
        .def(
            "poses",
            [](const Skeleton& skeleton, const OptionalArray& turns, const ArrayLike& moves) {
                return pose_array(skeleton.poses(posture_of(skeleton, turns, moves)));
            },
            py::arg("turns") = py::none(), py::arg("moves") = py::none(),
            R"(Rigid maps from rest (k, 3, 4), which are poses of handles.

turns, moves  (k, 3) the posture; None for zeros.

Raises InvalidConstraint.)")
        .def(
            "rotations",
            [](const Skeleton& skeleton, const OptionalArray& turns) {
                return rotation_array(skeleton.rotations(posture_of(skeleton, turns, py::none())));
            },
            py::arg("turns"), R"(The rotation of each joint in the bone's own axes (k, 3, 3).

turns  (k, 3)

Raises InvalidConstraint.)")
        .def(
            "turns",
            [](const Skeleton& skeleton, const ArrayLike& rotations) {
                return to_numpy(std::move(skeleton.posture(bone_rotations(rotations, "rotations")).turns));
            },
            py::arg("rotations"), R"(The turns (k, 3) that give these rotations, within the limits or not.

rotations  (k, 3, 3) of each joint, in the bone's own axes.

Raises InvalidConstraint.)")
        .def(
            "regions",
            [](const Skeleton& skeleton, const SurfaceMesh& mesh, double margin) {
                std::vector<std::vector<int>> regions;
                {
                    const py::gil_scoped_release unlocked;
                    regions = bone_regions(mesh, skeleton, margin);
                }
                py::list arrays;
                for (const std::vector<int>& vertices : regions)
                    arrays.append(to_numpy(vertices));
                return arrays;
            },
            py::arg("mesh"), py::arg("margin") = 0.25,
            R"(The vertices that each bone holds, k arrays (m_i,) of indices: the rigid middles of the limbs.

mesh    SurfaceMesh around the bones at rest.
margin  in [0, 0.5): how much of a bone's length is left free at each joint.

Distances go along the surface. A bone outside, or inside of another one's limb, holds none. Raises InvalidOption.)")
        .def(
            "solve",
            [](const Skeleton& skeleton, const ArrayLike& bones, const ArrayLike& points,
               const OptionalArray& goals, const OptionalArray& weights, const OptionalArray& turns,
               const ArrayLike& moves, const OptionalArray& moving_roots, const OptionalArray& locked,
               const OptionalArray& support, const OptionalArray& up, const OptionalArray& masses,
               const OptionalArray& centres, double rest, double pole, int max_iterations, double tolerance,
               double swing) {
                return solve_skeleton(skeleton, bones, points, goals, weights, turns, moves, moving_roots,
                                      locked, support, up, masses, centres,
                                      {rest, pole, max_iterations, tolerance, swing});
            },
            py::arg("bones"), py::arg("points"), py::arg("goals"), py::kw_only(),
            py::arg("weights") = py::none(), py::arg("turns") = py::none(), py::arg("moves") = py::none(),
            py::arg("moving_roots") = py::none(), py::arg("locked") = py::none(),
            py::arg("support") = py::none(), py::arg("up") = py::none(), py::arg("masses") = py::none(),
            py::arg("centres") = py::none(), py::arg("rest") = PoseSolverOptions{}.rest,
            py::arg("pole") = PoseSolverOptions{}.pole,
            py::arg("max_iterations") = PoseSolverOptions{}.max_iterations,
            py::arg("tolerance") = PoseSolverOptions{}.tolerance,
            py::arg("swing") = PoseSolverOptions{}.swing,
            R"(The posture in which points on bones come to their goals -> (turns, moves, PoseReport).

bones, points   (t,) and (t, 3): a bone for each target, and a point that it carries, at rest.
goals           (t, 3) where these points are wanted.
weights         None (1) or (t,) numbers > 0.
turns, moves    (k, 3) the posture to stay close to, from which every solve starts; None for zeros.
moving_roots    None, a flag or (k,) flags: the bones without a parent that may move.
locked          None, a flag or (k,) flags: the bones that do not turn.
support         None, or (m, 3) points: the centre of mass stays over their convex hull, seen along `up`.
up              None for z, or (3,) the direction against gravity.
masses          None (the lengths of the bones), a number or (k,) numbers >= 0.
centres         None (their middles) or (k, 3): where the bones' masses are, at rest.
rest            >= 0: how much it counts that joints turn, beside the targets.
pole            >= 0, radians: how far joints are bent at the start, so that straight chains can bend.
max_iterations  >= 1.
tolerance       >= 0: stop when a step lowers F by at most this share of it.
swing           >= 0: how much more it counts that a joint turns aside of its hinge than about it. 0 lets knees and
                elbows bend to any side.

Limits are never exceeded. Goals and a support out of reach are approached, and the report says by how much they are
missed. Raises InvalidConstraint or InvalidOption.)")
        .def("__repr__", [](const py::object& self) {
            const int count = self.cast<const Skeleton&>().bone_count();
            return representation(self, std::to_string(count) + " bones");
        });
}

const MethodBinding skeleton_binding(&bind_skeleton);

} // namespace

} // namespace sinew::bindings
