// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/map_blend.h"

#include "tests/native/shapes.h"

namespace sinew::test_map_blend {

/// Of as many handles on one triangle.
Matrix3 blended(const std::vector<Matrix3>& maps, const std::vector<double>& shares)
{
    const Components parts{1, {0, 0, 0}};
    const Regions regions(std::vector<Handle>(maps.size(), {{0}, {0.5}}), parts);
    const MapBlend blend(HandleGroups(regions, parts), maps);
    const VectorX nine = blend.values().transpose() * Eigen::Map<const VectorX>(shares.data(), shares.size());
    const MapBlend::Map map = blend.at(0, nine.data());
    Matrix3 T;
    for (int axis = 0; axis < 3; ++axis)
        T.col(axis) = map(Vector3::Unit(axis));
    return T;
}

TEST(MapBlend, a_share_of_one_is_the_map_itself_even_where_it_reflects_or_collapses)
{
    shapes::Random random(2);
    const Matrix3 A = random.matrix();
    EXPECT_EQ(blended({A, A, A}, {0.3, 0.1, 0.6}), A) << "to the bit";
    EXPECT_EQ(blended({A}, {1.0}), A);
    for (int k = 0; k < 20; ++k) {
        std::vector<Matrix3> maps{random.matrix(), random.rotation(), -random.rotation(), Matrix3::Zero()};
        for (std::size_t h = 0; h < maps.size(); ++h) {
            std::vector<double> shares(maps.size(), 0.0);
            shares[h] = 1.0;
            EXPECT_LT((blended(maps, shares) - maps[h]).norm(), 1e-13);
        }
    }
}

TEST(MapBlend, of_turns_about_one_axis_turns_by_the_mean_angle)
{
    const auto about = [](double degrees) { return shapes::rotation({1, 2, 2}, degrees); };
    EXPECT_LT((blended({about(-100), about(0), about(100)}, {0.5, 0.25, 0.25}) - about(-25)).norm(), 1e-13);
    EXPECT_LT((blended({about(170), about(0)}, {0.5, 0.5}) - about(85)).norm(), 1e-13);
    EXPECT_LT((blended({about(190), about(0)}, {0.5, 0.5}) - about(-85)).norm(), 1e-13) << "the shorter way";
    EXPECT_LT((blended({about(170), about(0)}, {2, -1}) - about(340)).norm(), 1e-13)
        << "as beyond the end of a falloff curve";
}

TEST(MapBlend, rounding_does_not_choose_the_way_of_half_a_turn)
{
    for (const Vector3& axis :
         {Vector3(0, 0, 1), Vector3(1, 1, 0), Vector3(-1, 2, 0.5), Vector3(1e-12, 0, -1)}) {
        const auto half = [&](double degrees) -> Matrix3 {
            return blended({shapes::rotation(axis, degrees), Matrix3::Identity()}, {0.5, 0.5});
        };
        for (double rounding : {-1e-11, 1e-11, 1e-13}) // degrees
            EXPECT_LT((half(180 + rounding) - half(180)).norm(), 1e-8);
    }
}

TEST(MapBlend, the_map_of_a_handle_that_aims_from_rest_leaves_out_how_its_patch_was_turned)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Regions regions(shapes::ends(mesh, 1.5), connected_components(mesh));
    const Pose turned = shapes::turn({1, 2, 0}, 50, {1, 1, 1}, {3, 0, 0}), pose = shapes::turn({0, 0, 1}, 30);
    const Points incoming = shapes::transformed(mesh.points(), turned);
    const std::vector<bool> from_rest{true, false};
    const Poses poses{pose, pose};
    const Targets targets{poses, view(mesh.points()), view(incoming), &from_rest};
    const std::vector<Matrix3> maps = linear_maps(targets, handle_patches(mesh, regions));
    EXPECT_LT((maps[0] - pose.leftCols<3>() * turned.leftCols<3>().transpose()).norm(), 1e-13);
    EXPECT_EQ(maps[1], Matrix3(pose.leftCols<3>()));
    // A handle of one vertex has its ring.
    const Regions single({{{40}, {}}, {{0}, {}}}, connected_components(mesh));
    EXPECT_LT((linear_maps(targets, handle_patches(mesh, single))[0] - maps[0]).norm(), 1e-13);
}

} // namespace sinew::test_map_blend
