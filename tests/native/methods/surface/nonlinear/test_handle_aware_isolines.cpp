// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/handle_aware_isolines.h"

#include "tests/native/methods/surface/contract.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace sinew::test_handle_aware_isolines {

namespace {

using Options = HandleAwareIsolinesOptions;

auto maker(const Options& options)
{
    return
        [options](const SurfaceMesh& mesh) { return std::make_shared<HandleAwareIsolines>(mesh, options); };
}

/// The end at `along` goes to the end of a circular arc.
Poses bend(double degrees, double along = 12, double depth = 2)
{
    const double angle = degrees * shapes::pi / 180, radius = (along - 2 * depth) / angle;
    const Vector3 end(depth + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    const Vector3 from(along - depth, 0, 0);
    return {shapes::still(), shapes::turn({0, 0, 1}, degrees, from, end - from)};
}

SurfaceTraits traits()
{
    const auto drag = [](double s) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
        return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 100 * t, {18, 0, 0},
                                                   {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * s)})};
    };
    return {.name = "HandleAwareIsolines",
            .variants = {{"default", maker({}), 1, true},
                         {"few bands", maker({.bands = 5}), 1, true},
                         {"geodesic", maker({.field = Field::geodesic}), 1, true}},
            .mesh = shapes::bar(12, 3),
            .large = shapes::bar(20, 5),
            .depth = 2,
            .bent = bend(60),
            .drag = drag,
            .drag_steps = 30,
            .follow = 1.5, // the surface between two handles follows the faster one
            .slack = 0.02,
            .rest = 1e-13,     // rounding of the fits
            .incoming = 1e-11, // edges are taken from what enters: nothing is strained
            .noise = 0.2,
            .translation = 1e-9,
            .rigid = 1e-12, // everything is relative to a rigid motion
            .held = 1e-13,
            .alone = 1e-13,
            .similar = 1e-4, // columns are stored in single precision, and turns end at 1e-6
            .scaled = 1e-4,
            .apart = 1e-5, // single precision, of columns that are summed up in another order
            .messy = 30.0,
            .folded = 1e-5,
            .all_soft = 1.0,
            .updates = "bands",
            .updated = maker({.bands = 8})};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(HandleAwareIsolines, SurfaceContract, testing::Values(traits()));

TEST(HandleAwareIsolines, refuses_options_out_of_range)
{
    const SurfaceMesh mesh = shapes::octahedron();
    EXPECT_THROW(HandleAwareIsolines(mesh, {.bands = 1}), InvalidOption);
    EXPECT_THROW(HandleAwareIsolines(mesh, {.max_iterations = 0}), InvalidOption);
    EXPECT_THROW(HandleAwareIsolines(mesh, {.tolerance = -1.0}), InvalidOption);
}

} // namespace sinew::test_handle_aware_isolines
