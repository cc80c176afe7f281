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

} // namespace sinew::test_embedded_deformation
