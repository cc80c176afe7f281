// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/moving_frames.h"

#include "tests/native/shapes.h"

namespace sinew::test_moving_frames {

/// Where the last frame of some goes, each on all triangles of a mesh.
struct Moved
{
    Matrix3 rotation;
    double scale;
    Vector3 from, to;

    Moved(const std::vector<SurfaceMesh>& meshes, const Points& before, const Points& after)
    {
        MovingFrames frames;
        for (const SurfaceMesh& mesh : meshes) {
            const std::vector<double> even(mesh.triangles().size(), 1.0 / mesh.triangles().size());
            frames.add(mesh.triangles(), even, even);
        }
        FrameRests rests;
        frames.resize(rests);
        for (int four = 0; four < frames.four_count(); ++four)
            frames.measure(four, view(before), rests);
        const int last = static_cast<int>(meshes.size()) - 1, lane = last % 4;
        const FourMotions motions = frames.fit(last / 4, rests, view(after));
        scale = motions.scales[lane];
        for (int k = 0; k < 9; ++k)
            rotation(k / 3, k % 3) = motions.rotations[k][lane];
        for (int k = 0; k < 3; ++k) {
            from[k] = rests.fours[last / 4].anchors[k][lane];
            to[k] = motions.anchors[k][lane];
        }
    }
    Moved(const SurfaceMesh& mesh, const Pose& pose)
        : Moved({mesh}, mesh.points(), shapes::transformed(mesh.points(), pose))
    {
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
    const Points bent = shapes::transformed(many.points(), shapes::affine(shapes::rotation({1, 2, 3}, 30)));
    std::vector<SurfaceMesh> others;
    for (const SurfaceMesh& mesh : {many, few, many, few, many, few, many, few, many}) {
        others.push_back(mesh);
        for (const SurfaceMesh& last : {few, many}) {
            std::vector<SurfaceMesh> all = others;
            all.push_back(last);
            const Moved among(all, many.points(), bent), alone({last}, many.points(), bent);
            EXPECT_EQ(among.scale, alone.scale) << others.size();
            EXPECT_EQ(among.rotation, alone.rotation) << others.size();
            EXPECT_EQ(among.to, alone.to) << others.size();
        }
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
