// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/ring_rotations.h"

#include "tests/native/methods/multiresolution/bumpy_plate.h"

#include <gtest/gtest.h>

namespace sinew::test_ring_rotations {

namespace {

std::vector<Matrix3> rotations(const SurfaceMesh& mesh, const Points& after)
{
    std::vector<Matrix3> found(mesh.vertex_count(), Matrix3::Zero()), maps;
    RingRotations(mesh).fit(
        view(mesh.points()), view(after), maps, [](int) { return true; },
        [&](int v, const Matrix3& R, const Matrix3& /*sum*/) { found[v] = R; });
    return found;
}

} // namespace

TEST(RingRotations, equal_shapes_give_the_identity_also_on_messy_meshes)
{
    for (const SurfaceMesh& mesh : {shapes::hill(8, 8), shapes::messy(), shapes::bar(6, 2)}) {
        const Pose pose = shapes::turn({1, 2, 3}, 130, {1, 1, 1}, {4, 0, 2});
        const std::vector<Matrix3> still = rotations(mesh, mesh.points()),
                                   turned = rotations(mesh, shapes::transformed(mesh.points(), pose));
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            EXPECT_LT((still[v] - Matrix3::Identity()).norm(), 1e-14);
            const bool loose = (turned[v] - Matrix3::Identity()).norm() == 0; // in no face
            EXPECT_LT(loose ? 0 : (turned[v] - pose.leftCols<3>()).norm(), 1e-12);
        }
    }
}

TEST(RingRotations, of_a_shape_that_stays_are_the_same_to_the_last_bit)
{
    const SurfaceMesh mesh = shapes::messy();
    shapes::Random random(7);
    const Points after = mesh.points() * random.rotation() + 0.2 * random.dense(mesh.vertex_count(), 3);
    const RingRotations rings(mesh);
    const std::vector<Matrix3> expected = rotations(mesh, after);
    std::vector<Matrix3> maps;
    rings.fit(
        rings.duals(view(mesh.points())), view(after), maps, [](int) { return true; },
        [&](int v, const Matrix3& R, const Matrix3& /*sum*/) { EXPECT_EQ(R, expected[v]) << v; });
}

} // namespace sinew::test_ring_rotations
