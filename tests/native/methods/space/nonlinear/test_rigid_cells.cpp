// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/rigid_cells.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/nonlinear/handle_contract.h"
#include "tests/native/methods/space/nonlinear/handle_shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>

namespace sinew::test_rigid_cells {

namespace {

using Options = RigidCellsOptions;

const SurfaceMesh bar = shapes::bar(24, 6);

std::shared_ptr<RigidCells> made(const Options& options)
{
    return std::make_shared<RigidCells>(bar, shapes::held_ends(bar, 2.0), options);
}

SpaceTraits traits()
{
    const auto make = [](Options options) { return [options] { return made(options); }; };
    return {
        .name = "RigidCells",
        .variants = {{"300 cells", make({.cells = 300})}, {"one size", make({.cells = 120, .levels = 0})}},
        .control = shapes::held_ends(bar, 2.0).points(),
        .points = bar.points(),
        .follow = 1.5,
        .outside = Vector3(-5, 0, 0),
        .other = make({.cells = 301})};
}

HandleTraits handle_traits()
{
    HandleTraits result{.name = "RigidCells",
                        .make =
                            [](const SurfaceMesh& mesh, const HandlePoints& handles) {
                                return std::make_shared<RigidCells>(mesh, handles, Options{.cells = 300});
                            },
                        .answer =
                            [](const HandleMethod& method, const Poses& poses, HandleTraits::Start start,
                               double tolerance, int most) {
                                auto found = dynamic_cast<const RigidCells&>(method).answer(
                                    poses,
                                    start == HandleTraits::Start::usual ? RigidCells::Start::cascade
                                                                        : RigidCells::Start::rest,
                                    tolerance, most);
                                return HandleTraits::Answer{std::move(found.centres), found.report};
                            },
                        .meet = 1e-2,
                        .turns_alone = 40.0}; // one of some cells across turns, and takes the others along
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Options& options : std::vector<Options>{{.cells = 7},
                                                       {.cells = 100001},
                                                       {.levels = -1},
                                                       {.levels = 7},
                                                       {.max_iterations = 0},
                                                       {.tolerance = nan}})
        result.out_of_range.emplace_back([options] { made(options); });
    return result;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(RigidCells, SpaceContract, testing::Values(traits()));
INSTANTIATE_TEST_SUITE_P(RigidCells, HandleContract, testing::Values(handle_traits()));

TEST(RigidCells, one_rigid_motion_is_exact_whatever_the_cells)
{
    for (const Options& options : {Options{.cells = 40, .levels = 0}, {.cells = 2000, .levels = 3}}) {
        const std::shared_ptr<RigidCells> method = made(options);
        method->bind(view(bar.points()));
        const Pose rigid = shapes::turn({1, 2, -1}, 170, {5, 1, 0}, {3, -4, 2});
        EXPECT_LT(
            shapes::apart(shapes::warped(*method, {rigid, rigid}), shapes::transformed(bar.points(), rigid)),
            1e-11)
            << options.cells << " cells";
    }
}

} // namespace sinew::test_rigid_cells
