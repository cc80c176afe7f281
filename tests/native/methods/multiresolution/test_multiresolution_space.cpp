// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/multiresolution_space.h"

#include "native/methods/space/nonlinear/mls.h"
#include "native/methods/space/points/rbf.h"
#include "native/methods/space/points/space_propagation.h"
#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/handle_points/fixture.h"
#include "tests/native/methods/space/nonlinear/handle_shapes.h"
#include "tests/native/refusals.h"

#include <gtest/gtest.h>

namespace sinew::test_multiresolution_space {

namespace {

using handles::posed, handles::warped;

constexpr WeightPrecision doubles = WeightPrecision::double_precision;
constexpr DetailKind every_coding[] = {DetailKind::displacement_vectors, DetailKind::normal_displacements,
                                       DetailKind::displacement_volumes, DetailKind::deformation_transfer};

SurfaceMesh plate() { return shapes::hill(16, 14); }

/// Both ends along x.
HandlePoints ends_of(const SurfaceMesh& mesh) { return shapes::held_ends(mesh, 1.5); }

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

// What it does to details is in tests/bindings/spaces/test_handle_points.py.
INSTANTIATE_TEST_SUITE_P(MultiresolutionSpace, SpaceContract, testing::Values(traits()));

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
