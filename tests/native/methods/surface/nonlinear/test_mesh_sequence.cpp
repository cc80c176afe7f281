// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_sequence.h"

#include "tests/native/dense.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"
#include "tests/native/threads.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

namespace sinew::test_mesh_sequence {

namespace {

constexpr int length = 24;

using calls::bend;

/// An animation that bends, twists, swells and carries a bar about; `share` of its length, [0, 1).
Points animated(const SurfaceMesh& mesh, double share)
{
    const double phase = 2 * shapes::pi * share, bent = std::sin(phase) * 0.9 / length,
                 twist = 0.7 * std::sin(phase) / length;
    const Pose carried = shapes::turn({1, 2, -1}, 90 * share, {5, 1, 0}, {6 * std::sin(phase), 0, 3 * share});
    Points points = mesh.points();
    for (int i = 0; i < points.rows(); ++i) {
        const double x = points(i, 0), a = twist * x, swell = 1 + .1 * std::sin(phase + x);
        const double y = swell * (std::cos(a) * points(i, 1) - std::sin(a) * points(i, 2));
        const double z = swell * (std::sin(a) * points(i, 1) + std::cos(a) * points(i, 2));
        Vector3 p(x, y, z);
        if (std::abs(bent) > 1e-9)
            p = {std::sin(bent * x) * (1 / bent - y), 1 / bent - std::cos(bent * x) * (1 / bent - y), z};
        points.row(i) = apply(carried, p);
    }
    return points;
}

SurfaceMesh bar() { return shapes::bar(length, 4); }

class MeshSequence : public SurfaceFixture<sinew::MeshSequence, ArapOptions>
{
public:
    /// Poses without a frame: what Arap promises, with the tolerances of its test.
    static SurfaceTraits traits()
    {
        SurfaceTraits made = nonlinear(
            "MeshSequence", {{"default", maker(), 2, false},
                             {"rims", maker({.smoothness = 0, .cells = ArapOptions::Cells::rims}), 1}});
        made.other = maker({.rigidity = {2.0}});
        return made;
    }
    static Method bound(const SurfaceMesh& mesh, const std::vector<Handle>& handles)
    {
        return SurfaceFixture::bound(mesh, {}, handles);
    }
    static Method bound(const SurfaceMesh& mesh) { return bound(mesh, shapes::ends(mesh, 2)); }
};

SolveRequest entering(const Points& shape, int handles = 2)
{
    return {.poses = Poses(handles, shapes::still()), .incoming = view(shape)};
}

Points frame_of(const sinew::MeshSequence& sequence, double frame, const EditKeys& keys,
                const SolveRequest& request)
{
    Points positions;
    sequence.solve_frame(frame, keys, request, positions);
    return positions;
}

/// The moving frame of a handle by a singular value decomposition, written down once more.
Pose moving_frame(const SurfaceMesh& rest, const std::vector<int>& handle, const Points& shape)
{
    std::vector<bool> holds(rest.vertex_count(), false);
    for (int v : handle)
        holds[v] = true;
    std::vector<int> corners;
    for (const Triangle& t : rest.triangles())
        for (int k = 0; k < 3; ++k)
            if (holds[t[k]])
                corners.insert(corners.end(), t.begin(), t.end());
    const auto mean = [](const Points& of, const std::vector<int>& some) {
        Vector3 sum = Vector3::Zero();
        for (int v : some)
            sum += of.row(v).transpose() / static_cast<double>(some.size());
        return sum;
    };
    const Vector3 before = mean(rest.points(), corners), now = mean(shape, corners);
    Matrix3 S = Matrix3::Zero();
    for (int v : corners)
        S += (shape.row(v).transpose() - now) * (rest.point(v) - before).transpose();
    return shapes::affine(dense::rotation_of(S), mean(shape, handle));
}

/// c + Q E(Q^T (x - c))
Vector3 edited(const Pose& frame, const Pose& edit, const Vector3& x)
{
    const Matrix3 Q = frame.leftCols<3>();
    return frame.col(3) + Q * apply(edit, Q.transpose() * (x - frame.col(3)));
}

EditKeys some_keys()
{
    return EditKeys({{0, 1, shapes::still()},
                     {30, 1, shapes::affine(shapes::rotation({0.2, 1, 0}, 35), {1, 2, 5})},
                     {59, 1, shapes::still()}});
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MeshSequence, SurfaceContract, testing::Values(MeshSequence::traits()));

TEST_F(MeshSequence, edits_at_keys_are_met_in_the_moving_frame)
{
    const SurfaceMesh mesh = bar();
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    const Method sequence = bound(mesh, ends);
    shapes::Random random(4);
    std::vector<EditKey> all;
    for (int f : {5, 20, 41})
        for (int h : {0, 1})
            all.push_back(
                {static_cast<double>(f), h,
                 shapes::affine(shapes::rotation(random.vector(), 60) * Vector3(1.2, 1, .8).asDiagonal(),
                                2 * random.vector())});
    const EditKeys keys(all);
    for (const EditKey& key : all) {
        const Points shape = animated(mesh, key.frame / 60);
        const Points found = frame_of(sequence, key.frame, keys, entering(shape));
        const Pose frame = moving_frame(mesh, ends[key.handle].vertices, shape);
        for (int v : ends[key.handle].vertices) // rounding of a fit at size 30
            EXPECT_LT((found.row(v).transpose() - edited(frame, key.edit, shape.row(v).transpose())).norm(),
                      1e-11);
    }
}

TEST_F(MeshSequence, an_edit_is_carried_by_what_carries_the_handle)
{
    // The same shape, elsewhere: the edited shape goes along, for an edit that was made at another frame.
    const SurfaceMesh mesh = bar();
    const Method sequence = bound(mesh);
    const Points here = animated(mesh, .2);
    const Pose carried = shapes::turn({1, -2, .5}, 130, {3, 7, 1}, {30, -20, 10});
    const Points there = shapes::transformed(here, carried);
    const Points edited_here = frame_of(sequence, 17, some_keys(), entering(here));
    EXPECT_GT(shapes::distance(edited_here, here), 1.0);
    // The iteration may end a step earlier: by a decrease below 1e-4.
    EXPECT_LT(shapes::distance(frame_of(sequence, 17, some_keys(), entering(there)),
                               shapes::transformed(edited_here, carried)),
              0.01);
}

TEST_F(MeshSequence, a_rigid_edit_of_all_handles_is_rigid_in_every_frame)
{
    const SurfaceMesh mesh = bar();
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    const Method sequence = bound(mesh, ends);
    const Pose whole = shapes::turn({1, 2, -.5}, 70, {3, 7, 1}, {5, -2, 3});
    std::vector<EditKey> all;
    for (int f = 0; f < 60; f += 6)
        for (int h : {0, 1}) {
            const Pose frame = moving_frame(mesh, ends[h].vertices, animated(mesh, f / 60.0));
            const Matrix3 Q = frame.leftCols<3>();
            all.push_back({static_cast<double>(f), h,
                           shapes::affine(Q.transpose() * whole.leftCols<3>() * Q,
                                          Q.transpose() * (apply(whole, frame.col(3)) - frame.col(3)))});
        }
    for (int f = 0; f < 60; f += 6) {
        const Points shape = animated(mesh, f / 60.0);
        EXPECT_LT(shapes::distance(frame_of(sequence, f, EditKeys(all), entering(shape)),
                                   shapes::transformed(shape, whole)),
                  1e-11 * shapes::size(shape));
    }
}

TEST_F(MeshSequence, frames_are_as_smooth_in_time_as_the_edit_of_the_handle)
{
    const SurfaceMesh mesh = bar();
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    const Method sequence = bound(mesh, ends);
    const int frames = 60;
    std::vector<Points> all, handle;
    for (int f = 0; f < frames; ++f) {
        const Points shape = animated(mesh, static_cast<double>(f) / frames);
        all.push_back(frame_of(sequence, f, some_keys(), entering(shape)) - shape);
        Points& held = handle.emplace_back(ends[1].vertices.size(), 3);
        for (std::size_t k = 0; k < ends[1].vertices.size(); ++k)
            held.row(static_cast<int>(k)) = all.back().row(ends[1].vertices[k]);
    }
    // The second difference in time, as a share of the edit, both as root mean squares.
    const auto jitter = [](const std::vector<Points>& edit) {
        double size = 0.0, jerk = 0.0;
        for (std::size_t f = 0; f < edit.size(); ++f) {
            size += edit[f].squaredNorm() / static_cast<double>(edit.size());
            if (f >= 2)
                jerk += (edit[f] - 2 * edit[f - 1] + edit[f - 2]).squaredNorm() /
                        static_cast<double>(edit.size() - 2);
        }
        return std::sqrt(jerk / size);
    };
    // .0140 and .0152: the animation itself swings the edit about.
    EXPECT_LT(jitter(all), 1.2 * jitter(handle));
    EXPECT_LT(jitter(all), 0.02);
}

TEST_F(MeshSequence, a_control_that_follows_the_animation_edits_by_what_it_does_beyond)
{
    const SurfaceMesh mesh = bar();
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    const Method sequence = bound(mesh, ends);
    const Points shape = animated(mesh, .6);
    SolveRequest request = entering(shape);
    request.from_rest = std::vector<bool>{false, true};
    request.poses = sequence.still_poses(request);
    EXPECT_EQ(request.poses[0], shapes::still());
    EXPECT_LT(shapes::distance(frame_of(sequence, 36, {}, request), shape), 1e-11);
    // Ten degrees about an axis of the control, in its frame: the same as a key.
    const Pose own = shapes::turn({0, 0, 1}, 10, moving_frame(mesh, ends[1].vertices, mesh.points()).col(3));
    Pose posed;
    posed << request.poses[1].leftCols<3>() * own.leftCols<3>(),
        request.poses[1].leftCols<3>() * own.col(3) + request.poses[1].col(3);
    request.poses[1] = posed;
    const EditKeys key({{36, 1, shapes::affine(shapes::rotation({0, 0, 1}, 10))}});
    EXPECT_LT(
        shapes::distance(frame_of(sequence, 36, {}, request), frame_of(sequence, 36, key, entering(shape))),
        1e-9);
}

TEST_F(MeshSequence, a_handle_of_one_vertex_turns_with_the_faces_around_it)
{
    const SurfaceMesh mesh = bar();
    const int tip = mesh.vertex_count() - 1;
    const Method sequence =
        bound(mesh, {{shapes::where(mesh, [](const Vector3& p) { return p.x() < 2; }), {}}, {{tip}, {}}});
    const Pose carried = shapes::turn({1, 0, 2}, 110, {1, 1, 1}, {4, 0, 0});
    const Points shape = shapes::transformed(mesh.points(), carried);
    const EditKeys key({{0, 1, shapes::shift(0, 0, 2)}});
    const Points found = frame_of(sequence, 0, key, entering(shape));
    const Vector3 up = carried.leftCols<3>() * Vector3(0, 0, 2);
    EXPECT_LT((found.row(tip) - shape.row(tip) - up.transpose()).norm(), 1e-12);
}

TEST_F(MeshSequence, a_line_of_vertices_moves_and_does_not_turn)
{
    const Points line = shapes::points_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
    const SurfaceMesh mesh = shapes::over(line, {{0, 1, 2}});
    const Method sequence = bound(mesh, {{{0}, {}}});
    const Points shape = shapes::transformed(line, shapes::turn({0, 0, 1}, 90, {0, 0, 0}, {5, 0, 0}));
    const EditKeys key({{3, 0, shapes::shift(1, 0, 0)}});
    const Points found = frame_of(sequence, 3, key, entering(shape, 1));
    EXPECT_LT((found.row(0) - shape.row(0) - Eigen::RowVector3d(1, 0, 0)).norm(), 1e-12);
}

TEST_F(MeshSequence, ten_threads_and_a_bind_between_do_no_harm)
{
    const SurfaceMesh mesh = bar();
    Method sequence = bound(mesh);
    const Points shape = animated(mesh, .5);
    const Points expected = frame_of(sequence, 30, some_keys(), entering(shape));
    in_threads(11, [&](int k) {
        if (k == 5)
            sequence.set_handles(shapes::ends(mesh, 2));
        else
            EXPECT_EQ(frame_of(sequence, 30, some_keys(), entering(shape)), expected);
    });
}

TEST_F(MeshSequence, a_rebind_takes_the_moving_frames_over)
{
    const SurfaceMesh mesh = bar();
    Method former = bound(mesh), next(mesh);
    const Points shape = animated(mesh, .5);
    const Points expected = frame_of(former, 30, some_keys(), entering(shape));
    EXPECT_EQ(next.rebind(former, shapes::ends(mesh, 2)).reuse, Reuse::kept);
    EXPECT_EQ(frame_of(next, 30, some_keys(), entering(shape)), expected);
    EXPECT_EQ(frame_of(former, 30, {}, entering(shape, 0)), shape); // it has no handles any more
    EXPECT_EQ(frame_of(Method(mesh), 30, {}, entering(shape, 0)), shape);
}

TEST_F(MeshSequence, refuses_what_does_not_fit_and_names_it)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const SurfaceMesh mesh = bar();
    const Method sequence = bound(mesh);
    const Points shape = animated(mesh, .5);
    const auto solve = [&](double frame, const EditKeys& keys, const SolveRequest& request) {
        return [&sequence, frame, keys, request] { frame_of(sequence, frame, keys, request); };
    };
    const InvalidConstraint error = refusal<InvalidConstraint>(solve(nan, {}, entering(shape)));
    EXPECT_NE(std::string(error.what()).find("frame"), std::string::npos) << error.what();
    EXPECT_THROW(solve(1, {}, entering(shape, 3))(), InvalidConstraint);
    EXPECT_THROW(sequence.edits(nan, {}, entering(shape)), InvalidConstraint);
    EXPECT_THROW(sequence.poses(0, {}, entering(shape, 1)), InvalidConstraint);
    EXPECT_THROW(sequence.still_poses(entering(shape, 1)), InvalidConstraint);
}

} // namespace sinew::test_mesh_sequence
