// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_sequence.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"
#include "tests/native/threads.h"

#include <gtest/gtest.h>

namespace sinew::test_mesh_sequence {

namespace {

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
};

/// A frame of a shape that enters, which a key moves where there are handles.
Points frame_of(const sinew::MeshSequence& sequence, const Points& shape, int handles = 2)
{
    EditKeys keys;
    if (handles)
        keys = EditKeys({{30, 1, shapes::affine(shapes::rotation({0.2, 1, 0}, 35), {1, 2, 5})}});
    Points positions;
    sequence.solve_frame(30, keys, {.poses = Poses(handles, shapes::still()), .incoming = view(shape)},
                         positions);
    return positions;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MeshSequence, SurfaceContract, testing::Values(MeshSequence::traits()));

// What the frames are is in tests/bindings/surfaces/test_mesh_sequence.py.
TEST_F(MeshSequence, ten_threads_a_bind_between_and_a_rebind_do_frames_no_harm)
{
    const SurfaceMesh mesh = shapes::bar(24, 4);
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    Method former = bound(mesh, {}, ends), next(mesh);
    const Points shape = shapes::Random(2).shaken(mesh.points(), 0.1);
    const Points expected = frame_of(former, shape);
    EXPECT_GT(shapes::distance(expected, shape), 1);
    in_threads(11, [&](int k) {
        if (k == 5)
            former.set_handles(ends);
        else
            EXPECT_EQ(frame_of(former, shape), expected);
    });
    EXPECT_EQ(next.rebind(former, ends).reuse, Reuse::kept);
    EXPECT_EQ(frame_of(next, shape), expected);
    EXPECT_EQ(frame_of(former, shape, 0), shape) << "it has no handles any more";
    EXPECT_EQ(frame_of(Method(mesh), shape, 0), shape);
}

} // namespace sinew::test_mesh_sequence
