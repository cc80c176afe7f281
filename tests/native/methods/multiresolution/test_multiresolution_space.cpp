// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/multiresolution_space.h"

#include "native/methods/space/nonlinear/mls.h"
#include "native/methods/space/points/rbf.h"
#include "native/methods/space/points/space_propagation.h"
#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"
#include "tests/native/refusals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_multiresolution_space {

namespace {

using handles::posed, handles::warped;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;
constexpr DetailKind every_coding[] = {DetailKind::displacement_vectors, DetailKind::normal_displacements,
                                       DetailKind::displacement_volumes, DetailKind::deformation_transfer};

SurfaceMesh plate() { return shapes::hill(16, 14); }

/// Both ends along x.
HandlePoints ends_of(const SurfaceMesh& mesh)
{
    const double low = mesh.points().col(0).minCoeff(), high = mesh.points().col(0).maxCoeff();
    std::vector<int> counts{0, 0};
    std::vector<Vector3> points;
    for (const double end : {low, high})
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (std::abs(mesh.point(v)[0] - end) < 1.5) {
                points.push_back(mesh.point(v));
                ++counts[end == low ? 0 : 1];
            }
    const Points places = shapes::points_of(points);
    return HandlePoints(view(places), counts);
}

template <class Base>
std::shared_ptr<MultiresolutionSpace> around(const SurfaceMesh& mesh, std::shared_ptr<Base> base,
                                             const MultiresolutionOptions& options = {})
{
    return std::make_shared<MultiresolutionSpace>(ends_of(mesh), std::move(base), mesh, options);
}

std::shared_ptr<Rbf> smooth_base(const SurfaceMesh& mesh)
{
    return std::make_shared<Rbf>(ends_of(mesh), RbfOptions{.precision = doubles});
}

SpaceTraits traits()
{
    const SurfaceMesh mesh = plate();
    std::vector<SpaceVariant> variants;
    for (const DetailKind coding : every_coding)
        variants.push_back({"coding " + std::to_string(static_cast<int>(coding)),
                            [=] { return around(mesh, smooth_base(mesh), {.details = coding}); }});
    variants.push_back({"mls", [=] {
                            return around(mesh, std::make_shared<Mls>(ends_of(mesh)),
                                          {.wavelength = 5.0, .bands = 2});
                        }});
    return {.name = "MultiresolutionSpace",
            .variants = variants,
            .control = ends_of(mesh).control(),
            .points = mesh.points(),
            .translation = 1e-9, // of a factor, with volumes and transfer
            .follow = 30.0,      // a step of one point of a frame is a shear
            .other = [=] { return around(mesh, smooth_base(mesh), {.wavelength = 3.0}); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(MultiresolutionSpace, SpaceContract, testing::Values(traits()));

TEST(MultiresolutionSpace, a_rigid_motion_of_the_base_moves_all_rigidly_and_no_edit_reconstructs)
{
    const SurfaceMesh mesh = plate();
    const Pose turn = shapes::turn({1, 2, 3}, 110, {3, 1, 0}, {2, -1, 4});
    Pose nearly = shapes::still();
    nearly(0, 3) = 1e-13;
    for (const DetailKind coding : every_coding) {
        const auto method = around(mesh, smooth_base(mesh), {.details = coding, .bands = 2});
        EXPECT_LT(shapes::distance(warped(*method, mesh.points(), posed(method->handles(), {turn, turn})),
                                   shapes::transformed(mesh.points(), turn)),
                  1e-8) // of factors with a condition of 1e6
            << static_cast<int>(coding);
        // Not the control at rest, for which nothing is computed.
        EXPECT_LT(shapes::distance(warped(*method, mesh.points(), posed(method->handles(), {nearly, nearly})),
                                   mesh.points()),
                  1e-8);
    }
}

TEST(MultiresolutionSpace, details_turn_with_the_base_and_handles_are_met)
{
    const SurfaceMesh mesh = plate();
    const HandlePoints handles = ends_of(mesh);
    const std::vector<Pose> poses{shapes::still(), shapes::turn({0, 1, 0}, 60, {16, 0, 0}, {-2, 0, 4})};
    const auto method = around(mesh, smooth_base(mesh), {.wavelength = 6.0});
    const Points found = warped(*method, mesh.points(), posed(handles, poses));
    for (int i = 0; i < handles.point_count(); ++i) {
        const Vector3 target =
            apply(poses[handles.handle_of(i)], Vector3(handles.points().row(i).transpose()));
        EXPECT_LT((found.rowwise() - target.transpose()).rowwise().norm().minCoeff(), 1e-8);
    }
    // The space method alone shears what stands on the base.
    Rbf alone(handles, {.precision = doubles});
    alone.bind(view(mesh.points()));
    Points sheared(mesh.vertex_count(), 3);
    const Points control = posed(handles, poses);
    alone.warp(view(control), {}, sheared.data());
    EXPECT_GT(shapes::distance(found, sheared), 1e-3);
}

TEST(MultiresolutionSpace, binds_some_vertices_and_names_points_that_are_none)
{
    const SurfaceMesh mesh = plate();
    const auto method = around(mesh, std::make_shared<SpacePropagation>(ends_of(mesh)));
    const Points control = posed(method->handles(), {shapes::still(), shapes::shift(0, 0, 2)});
    const Points all = warped(*method, mesh.points(), control), some = mesh.points().middleRows(40, 30);
    EXPECT_EQ(warped(*method, some, control), all.middleRows(40, 30));
    Points others = some;
    others(3, 0) += 0.1;
    expect_elements(refusal<InvalidConstraint>([&] { method->bind(view(others)); }), Error::Element::vertex,
                    {3});
    EXPECT_THROW(MultiresolutionSpace(ends_of(mesh), nullptr, mesh), InvalidOption);
}

} // namespace sinew::test_multiresolution_space
