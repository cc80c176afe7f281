// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/enclosed_volume.h"

#include "tests/native/differences.h"
#include "tests/native/shapes.h"

namespace sinew::test_enclosed_volume {

EnclosedVolume volume_of(const SurfaceMesh& mesh) { return {mesh.triangles(), mesh.vertex_count()}; }

/// A bar without one of its ends.
SurfaceMesh cup()
{
    const SurfaceMesh bar = shapes::bar(4, 2);
    shapes::Polygons faces = shapes::faces_of(bar);
    std::erase_if(faces, [&](const std::vector<int>& face) {
        return std::ranges::all_of(face, [&](int v) { return bar.point(v).x() > 3.9; });
    });
    return shapes::over(bar.points(), faces);
}

TEST(EnclosedVolume, closes_borders)
{
    const SurfaceMesh open = cup(), closed = shapes::bar(4, 2);
    const EnclosedVolume volume = volume_of(open);
    EXPECT_TRUE(volume.is_open());
    EXPECT_FALSE(volume_of(closed).is_open());
    constexpr double whole = 16.0;
    for (double away : {0.0, 1e3}) { // wherever the origin is
        const Points there = open.points().rowwise() + Eigen::RowVector3d(away, -away, away);
        EXPECT_NEAR(volume.of(view(there)), whole, 1e-9);
    }
    EXPECT_GT(volume.share_of_fans(view(open.points())), 0.05);
}

TEST(EnclosedVolume, has_the_gradient_of_differences_and_the_cubic_of_a_line)
{
    const SurfaceMesh mesh = cup();
    const EnclosedVolume volume = volume_of(mesh);
    shapes::Random random(3);
    const Points way = random.dense(mesh.vertex_count(), 3);
    Points gradient;
    EXPECT_NEAR(volume.gradient(view(mesh.points()), gradient), volume.of(view(mesh.points())), 1e-12);
    const auto at = [&](double s) {
        const Points there = mesh.points() + s * way;
        return volume.of(view(there));
    };
    EXPECT_NEAR(gradient.cwiseProduct(way).sum(), central_difference(at, 1e-5), 1e-8);
    const std::array<double, 4> c = volume.along(view(mesh.points()), view(way));
    for (double s : {-0.7, 0.2, 1.0})
        EXPECT_NEAR(c[0] + s * (c[1] + s * (c[2] + s * c[3])), at(s), 1e-11);
}

TEST(EnclosedVolume, steps_to_a_volume_or_says_that_it_cannot)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    const EnclosedVolume volume = volume_of(mesh);
    const double own = volume.of(view(mesh.points()));
    const Points still = Points::Zero(mesh.vertex_count(), 3);
    for (double wanted : {0.8 * own, 1.3 * own}) {
        const auto step = volume.step(view(mesh.points()), view(mesh.points()), wanted); // grows
        ASSERT_TRUE(step);
        EXPECT_NEAR(std::pow(1 + *step, 3) * own, wanted, 1e-12);
    }
    EXPECT_FALSE(volume.step(view(mesh.points()), view(still), 1.1 * own));
    EXPECT_FALSE(volume.step(view(mesh.points()), view(mesh.points()), -own)) << "that is far away";
}

} // namespace sinew::test_enclosed_volume
