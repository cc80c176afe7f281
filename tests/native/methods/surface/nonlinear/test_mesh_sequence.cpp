// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_sequence.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"
#include "tests/native/threads.h"

#include <gtest/gtest.h>

#include <utility>

namespace sinew::test_mesh_sequence {

namespace {

/// An animation that swells and carries a bar about; `share` of its length, [0, 1).
Points animated(const SurfaceMesh& mesh, double share)
{
    const double phase = 2 * shapes::pi * share;
    Points points = mesh.points();
    for (int i = 0; i < points.rows(); ++i)
        points.row(i).tail<2>() *= 1 + .1 * std::sin(phase + points(i, 0));
    return shapes::transformed(
        points, shapes::turn({1, 2, -1}, 90 * share, {5, 1, 0}, {6 * std::sin(phase), 0, 3 * share}));
}

SurfaceMesh bar() { return shapes::bar(24, 4); }

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
    static Method bound(const SurfaceMesh& mesh)
    {
        return SurfaceFixture::bound(mesh, {}, shapes::ends(mesh, 2));
    }
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

EditKeys some_keys()
{
    return EditKeys({{0, 1, shapes::still()},
                     {30, 1, shapes::affine(shapes::rotation({0.2, 1, 0}, 35), {1, 2, 5})},
                     {59, 1, shapes::still()}});
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MeshSequence, SurfaceContract, testing::Values(MeshSequence::traits()));

// What the frames are is in tests/bindings/surfaces/test_mesh_sequence.py.
TEST_F(MeshSequence, frames_in_parallel_have_the_same_bits_as_one_by_one)
{
    const SurfaceMesh mesh = bar();
    const Method sequence = bound(mesh);
    std::vector<double> numbers;
    std::vector<Points> shapes, found(12);
    std::vector<PointsView> views;
    for (int f = 0; f < 12; ++f) {
        numbers.push_back(5.0 * f);
        shapes.push_back(animated(mesh, f / 12.0));
    }
    for (const Points& shape : shapes)
        views.push_back(view(shape));
    sequence.solve_frames(numbers, some_keys(), views, {.poses = Poses(2, shapes::still())},
                          [&](int place, Points& positions) { found[place] = std::move(positions); });
    for (int f = 0; f < 12; ++f)
        EXPECT_EQ(frame_of(sequence, numbers[f], some_keys(), entering(shapes[f])), found[f]) << f;
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

} // namespace sinew::test_mesh_sequence
