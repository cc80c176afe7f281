// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/moving_frames.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew {

namespace {

/// How a frame on all triangles of a mesh moves with an affine map of it.
FrameMotion moved(const SurfaceMesh& mesh, const Pose& pose, const Vector3& origin)
{
    MovingFrames frames;
    const double share = 1.0 / static_cast<double>(mesh.triangles().size());
    const std::vector<double> weights(mesh.triangles().size(), share);
    frames.add(mesh.triangles(), weights, weights);
    const FrameRest rest = frames.rest(0, view(mesh.points()), origin);
    const Points after = shapes::transformed(mesh.points(), pose);
    return frames.move(0, rest, view(after));
}

} // namespace

TEST(MovingFrames, reproduce_similarities_of_every_patch)
{
    const std::vector<SurfaceMesh> patches{
        shapes::mesh({{1, 2, 3}, {2, 2, 3}, {1, 4, 3}}, {{0, 1, 2}}), // one triangle
        shapes::grid(1, 1),
        shapes::grid(8, 1),
        shapes::grid(3, 4),
        shapes::octahedron(),
        shapes::cube()};
    for (const SurfaceMesh& mesh : patches)
        for (double scale : {1.0, 1e-3, 70.0}) {
            const Matrix3 R = shapes::rotation({1, -2, 3}, 140);
            const Vector3 origin(.3, -.2, 5);
            const Pose pose = shapes::affine(scale * R, scale * Vector3(10, 20, 30));
            const FrameMotion motion = moved(mesh, pose, origin);
            EXPECT_LT((motion.rotation - R).norm(), 1e-13);
            EXPECT_NEAR(motion.log_scale, std::log(scale), 1e-13);
            EXPECT_LT((motion.place - apply(pose, origin)).norm(), 1e-13 * 50 * scale);
            EXPECT_EQ(motion.origin, origin);
        }
}

TEST(MovingFrames, take_their_scale_from_what_all_directions_share)
{
    const Vector3 origin(1, 1, 1);
    const auto scale = [&](const Vector3& stretch) {
        return moved(shapes::octahedron(), shapes::affine(Matrix3(stretch.asDiagonal())), origin).log_scale;
    };
    EXPECT_EQ(scale({3, 1, 1}), 0);
    EXPECT_EQ(scale({3, 1.0 / 3, 1}), 0);
    // The normals have their part in it, so that the figure is not exactly that of the axes.
    EXPECT_NEAR(scale({3, 2.5, 3}), std::log(2.5), .1);
    EXPECT_NEAR(scale({.3, .25, .3}), std::log(.3), .1);
    EXPECT_TRUE(std::isfinite(scale({0, 0, 0})));
}

} // namespace sinew
