// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/moving_frames.h"

#include "tests/native/shapes.h"

namespace sinew::test_moving_frames {

/// Where a frame on all triangles of a mesh goes.
struct Moved
{
    Matrix3 rotation;
    double scale;
    Vector3 from, to;

    Moved(const SurfaceMesh& mesh, const Pose& pose)
    {
        MovingFrames frames;
        const double share = 1.0 / static_cast<double>(mesh.triangles().size());
        const std::vector<double> weights(mesh.triangles().size(), share);
        frames.add(mesh.triangles(), weights, weights);
        FrameRests rests;
        frames.resize(rests);
        frames.measure(0, view(mesh.points()), rests);
        const Points after = shapes::transformed(mesh.points(), pose);
        const FourMotions motions = frames.fit(0, rests, view(after));
        scale = motions.scales[0];
        for (int k = 0; k < 9; ++k)
            rotation(k / 3, k % 3) = motions.rotations[k][0];
        for (int k = 0; k < 3; ++k) {
            from[k] = rests.fours[0].anchors[k][0];
            to[k] = motions.anchors[k][0];
        }
    }
};

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
            const Pose pose = shapes::affine(scale * R, scale * Vector3(10, 20, 30));
            const Moved motion(mesh, pose);
            EXPECT_LT((motion.rotation - R).norm(), 1e-13);
            EXPECT_NEAR(motion.scale / scale, 1, 1e-13);
            EXPECT_LT((motion.to - apply(pose, motion.from)).norm(), 1e-13 * 50 * scale);
        }
}

TEST(MovingFrames, do_not_depend_on_the_three_that_are_fitted_beside_them)
{
    const SurfaceMesh few = shapes::grid(1, 1), many = shapes::grid(3, 2);
    const auto even = [](const SurfaceMesh& mesh) {
        return std::vector<double>(mesh.triangles().size(), 1.0 / mesh.triangles().size());
    };
    const Points bent = shapes::transformed(many.points(), shapes::affine(shapes::rotation({1, 2, 3}, 30)));
    const auto last_of = [&](int others, const SurfaceMesh& mesh) {
        MovingFrames frames;
        for (int k = 0; k < others; ++k)
            frames.add(k % 2 ? few.triangles() : many.triangles(), even(k % 2 ? few : many),
                       even(k % 2 ? few : many));
        frames.add(mesh.triangles(), even(mesh), even(mesh));
        FrameRests rests;
        frames.resize(rests);
        for (int four = 0; four < frames.four_count(); ++four)
            frames.measure(four, view(many.points()), rests);
        const FourMotions motions = frames.fit(others / 4, rests, view(bent));
        std::vector<double> found{motions.scales[others % 4]};
        for (const auto& entry : motions.rotations)
            found.push_back(entry[others % 4]);
        for (const auto& entry : motions.anchors)
            found.push_back(entry[others % 4]);
        return found;
    };
    for (int others = 1; others < 10; ++others) {
        EXPECT_EQ(last_of(others, few), last_of(0, few)) << others;
        EXPECT_EQ(last_of(others, many), last_of(0, many)) << others;
    }
}

TEST(MovingFrames, take_their_scale_from_what_all_directions_share)
{
    const auto scale = [&](const Vector3& stretch) {
        return Moved(shapes::octahedron(), shapes::affine(Matrix3(stretch.asDiagonal()))).scale;
    };
    EXPECT_EQ(scale({3, 1, 1}), 1);
    EXPECT_EQ(scale({3, 1.0 / 3, 1}), 1);
    // The normals have their part in it, so that the figure is not exactly that of the axes.
    EXPECT_NEAR(std::log(scale({3, 2.5, 3})), std::log(2.5), .1);
    EXPECT_NEAR(std::log(scale({.3, .25, .3})), std::log(.3), .1);
    EXPECT_TRUE(std::isfinite(scale({0, 0, 0})));
}

} // namespace sinew::test_moving_frames
