// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/embedded_deformation.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/nonlinear/handle_contract.h"
#include "tests/native/methods/space/nonlinear/handle_shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>

namespace sinew::test_embedded_deformation {

namespace {

using Options = EmbeddedDeformationOptions;
using Start = EmbeddedDeformation::Start;

const SurfaceMesh bar = shapes::bar(24, 6);

std::shared_ptr<EmbeddedDeformation> made(const Options& options)
{
    return std::make_shared<EmbeddedDeformation>(bar, shapes::held_ends(bar, 2.0), options);
}

SpaceTraits traits()
{
    const auto make = [](Options options) { return [options] { return made(options); }; };
    return {.name = "EmbeddedDeformation",
            .variants = {{"60 nodes", make({.nodes = 60})},
                         {"stiff", make({.nodes = 30, .rotation = 10.0, .pulls = 1e4})}},
            .control = shapes::held_ends(bar, 2.0).points(),
            .points = bar.points(),
            .follow = 1.5,
            .deforms_what_enters = 1e-10, // of float32 solves, three of which leave less than that
            .other = make({.nodes = 61})};
}

HandleTraits handle_traits()
{
    HandleTraits result{
        .name = "EmbeddedDeformation",
        .make =
            [](const SurfaceMesh& mesh, const HandlePoints& handles) {
                return std::make_shared<EmbeddedDeformation>(mesh, handles, Options{.nodes = 60});
            },
        .answer =
            [](const HandleMethod& method, const Poses& poses, HandleTraits::Start start, double tolerance,
               int most) {
                auto found = dynamic_cast<const EmbeddedDeformation&>(method).answer(
                    poses, start == HandleTraits::Start::usual ? Start::handles : Start::no_rotations,
                    tolerance, most);
                return HandleTraits::Answer{std::move(found.unknowns), found.report};
            }};
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Options& options : std::vector<Options>{{.nodes = 0},
                                                       {.rotation = 0},
                                                       {.regularity = nan},
                                                       {.pulls = -1},
                                                       {.max_iterations = 0},
                                                       {.tolerance = nan}})
        result.out_of_range.emplace_back([options] { made(options); });
    return result;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(EmbeddedDeformation, SpaceContract, testing::Values(traits()));
INSTANTIATE_TEST_SUITE_P(EmbeddedDeformation, HandleContract, testing::Values(handle_traits()));

TEST(EmbeddedDeformation, rigid_handles_cost_nothing)
{
    const std::shared_ptr<EmbeddedDeformation> method = made({.nodes = 60});
    method->bind(view(bar.points()));
    for (const double angle : {10.0, 170.0, 180.0}) {
        const Pose rigid = shapes::turn({1, 2, -1}, angle, {5, 1, 0}, {3, -4, 2});
        EXPECT_LT(method->answer({rigid, rigid}, Start::handles, 1e-4, 40).report.energy, 1e-18)
            << angle; // the energy of a bend is about 1
    }
}

TEST(EmbeddedDeformation, does_not_depend_on_the_axes)
{
    const auto bound = [](const Points& points) {
        const SurfaceMesh mesh = shapes::moved(bar, points);
        std::vector<std::vector<int>> regions;
        for (const Handle& end : shapes::ends(bar, 2.0))
            regions.push_back(end.vertices);
        auto method = std::make_shared<EmbeddedDeformation>(mesh, shapes::held_by(mesh, regions),
                                                            Options{.nodes = 60, .tolerance = 1e-10});
        method->bind(view(mesh.points()));
        return method;
    };
    const Poses poses{shapes::still(), shapes::turn({0, 1, 0.3}, 50, {12, 0, 0}, {3, 0, 2})};
    const Points shape = shapes::warped(*bound(bar.points()), poses);
    const Pose frame = shapes::turn({0.5, 0.3, 0.8}, 46, {0, 0, 0}, {5, -3, 8});
    const Matrix3 back = frame.leftCols<3>().transpose();
    Poses turned;
    for (const Pose& pose : poses) {
        Pose& own = turned.emplace_back();
        own.leftCols<3>() = frame.leftCols<3>() * pose.leftCols<3>() * back;
        own.col(3) = frame.leftCols<3>() * pose.col(3) + frame.col(3) - own.leftCols<3>() * frame.col(3);
    }
    const Points found = shapes::warped(*bound(shapes::transformed(bar.points(), frame)), turned);
    // Of the stop, and of distances in single precision.
    EXPECT_LT(shapes::apart(found, shapes::transformed(shape, frame)), 1e-5);
}

} // namespace sinew::test_embedded_deformation
