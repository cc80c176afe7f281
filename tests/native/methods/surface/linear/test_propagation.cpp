// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/propagation.h"

#include "tests/native/allocations.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/methods/surface/linear/study_tube.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_propagation {

namespace {

class Propagation : public SurfaceFixture<sinew::Propagation, PropagationOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made =
            linear("Propagation", {{"harmonic", maker(), 1, true, 1e-12},
                                   {"geodesic", maker({.field = Field::geodesic}), 0, true, 1e-12},
                                   {"euclidean", maker({.field = Field::euclidean}), 0, true, 1e-12}});
        made.translation = 1e-12;
        made.rigid = 1e-13;
        made.similar = made.scaled = 1e-10;
        made.rides = 1e-12;
        made.updates = "transfer";
        made.updated = maker({.transfer = {0.0, 0.2, 1.0}});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Propagation, SurfaceContract, testing::Values(Propagation::traits()));

TEST_F(Propagation, twists_a_tube_evenly)
{
    const SurfaceMesh mesh = study_tube();
    for (Field field : {Field::harmonic, Field::geodesic, Field::euclidean}) {
        const Points q = solved(mesh, shapes::ends(mesh, 3.1),
                                {.poses = {shapes::still(), shapes::turn({1, 0, 0}, 135)}}, {.field = field});
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            const double s = std::clamp((mesh.point(v).x() - 3) / 14, 0.0, 1.0);
            EXPECT_LT((q.row(v).transpose() - shapes::rotation({1, 0, 0}, 135 * s) * mesh.point(v)).norm(),
                      1e-11);
        }
    }
}

TEST_F(Propagation, says_where_a_rule_chose_the_way_of_half_a_turn)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(8, 8), shapes::sphere(1), {0, 20, 0});
    std::vector<Handle> handles = shapes::ends(shapes::hill(8, 8), 1.5);
    handles.push_back({{81}, {}});
    for (const auto& [degrees, vertices] : {std::pair{179.0, 0}, {180.0, 81}}) {
        const Poses poses{shapes::still(), shapes::turn({1, 2, 0}, degrees), shapes::still()};
        EXPECT_EQ(solve(bound(mesh, {}, handles), poses).report.half_turns, vertices);
    }
}

TEST_F(Propagation, one_handle_alone_takes_everything_along_whatever_the_curve)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    const Pose pose =
        shapes::affine(Vector3(1.2, 0.8, -2).asDiagonal() * shapes::rotation({1, 2, 0}, 30), {1, 2, 3});
    EXPECT_LT(
        shapes::distance(solved(mesh, {{{45}, {0.3}}}, {.poses = {pose}}, {.transfer = {0.0, 0.3, 1.0}}),
                         shapes::transformed(mesh.points(), pose)),
        1e-12);
}

TEST_F(Propagation, refuses_curves_that_are_none)
{
    expect_refused(shapes::cube(), {{.transfer = {}}, {.transfer = {1.0}}, {.transfer = {0.0, nan, 1.0}}});
}

TEST_F(Propagation, allocates_nothing_in_proportion_to_the_mesh_in_a_solve)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    const Method propagation = bound(mesh, {}, shapes::ends(mesh, 1.5));
    Points positions(mesh.vertex_count(), 3);
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    for (int k = 0; k < 3; ++k)
        propagation.solve({bent}, positions);
    EXPECT_EQ(count.so_far(), 0);
}

} // namespace sinew::test_propagation
