// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/hierarchical_smoothing.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_hierarchical_smoothing {

namespace {

class HierarchicalSmoothing
    : public SurfaceFixture<sinew::HierarchicalSmoothing, HierarchicalSmoothingOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made = linear(
            "HierarchicalSmoothing",
            {{"hierarchy", maker({64, 4})}, {"one level", maker({0, 4})}, {"unrelaxed", maker({64, 0})}});
        made.mesh = shapes::hill(16, 10);
        made.large = shapes::hill(20, 18);
        made.allocates = {"one level"}; // its coarse mesh is the mesh itself
        made.rest = made.incoming = 1e-13; // each level takes its details apart and puts them together
        made.translation = 1e-8; // a single vertex leaves turns to the Laplacian of 1e-8
        made.rigid = 1e-11; // rounding errors, carried through all levels
        made.similar = 1e-9;
        made.many_enter = true;
        made.updates = "levels";
        made.updated = maker({2, 4});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(HierarchicalSmoothing, SurfaceContract,
                         testing::Values(HierarchicalSmoothing::traits()));

TEST_F(HierarchicalSmoothing, many_sweeps_come_to_the_smoothest_displacement)
{
    // Details of a plane are zero, so that each level goes on from the one before, to the same minimum.
    // More than a third of the 121 free vertices may go until 64 are left. So the first level takes all that
    // are no neighbours, and each of the others is near one of them.
    const SurfaceMesh mesh = shapes::grid(16, 10, 1.0, 0.2);
    const std::vector<Handle> handles = shapes::ends(mesh, 2.5);
    const Poses lift{shapes::still(), shapes::shift(0, 0, 3)};
    const Points smoothest = solved(mesh, handles, {.poses = lift}, {.levels = 0});
    double before = 1.0;
    for (int sweeps : {0, 4, 64, 20000}) {
        const double gap =
            shapes::distance(solved(mesh, handles, {.poses = lift}, {.relaxations = sweeps}), smoothest);
        EXPECT_LT(gap, before) << sweeps;
        before = gap;
    }
    EXPECT_LT(before, 5e-3)
        << "half a pixel of a lift drawn 300 pixels high; each level relaxes only what is near its "
           "new vertices";
}

TEST_F(HierarchicalSmoothing, planes_are_exact)
{
    // Whatever is linear on a plane is relaxed into itself, on all levels: the surface between handles that
    // agree with one linear map is that map, although no pose is alike.
    const SurfaceMesh mesh = shapes::grid(24, 16, 1.0, 0.25);
    const std::vector<Handle> handles = shapes::ends(mesh, 2.5);
    Matrix3 shear = Matrix3::Identity(), other = shear;
    shear(2, 0) = 0.4;
    shear(2, 1) = -0.3;
    shear(0, 0) = 1.2;
    other = shear;
    other(0, 2) = 0.7; // nothing on the plane is moved by it
    const Points q = solved(mesh, handles,
                            {.poses = {shapes::affine(shear, {1, 2, 3}), shapes::affine(other, {1, 2, 3})}});
    EXPECT_LT(shapes::distance(q, shapes::transformed(mesh.points(), shapes::affine(shear, {1, 2, 3}))), 1e-6)
        << "at free borders, the Laplacian of 1e-8 pulls a little";
}

TEST_F(HierarchicalSmoothing, details_turn_with_the_coarser_shape)
{
    // A plate with a fine pattern, whose end is turned up: single vertices that stand 0.05 above their
    // neighbours stand so along the normals of the turned plate, too. The bend of the plate shows in the same
    // way between vertices that stand alike, at three times the distance, which is nine times as much.
    const SurfaceMesh plain = shapes::grid(48, 16, 0.25);
    Points p = plain.points();
    for (int v = 0; v < p.rows(); ++v)
        p(v, 2) = (v % 3 == 0) * 0.05;
    const SurfaceMesh mesh = shapes::moved(plain, p);
    const Points q = solved(mesh, shapes::ends(mesh, 1.0),
                            {.poses = {shapes::still(), shapes::turn({0, 1, 0}, -80, {9, 0, 0})}});
    double worst = 0.0, steepest = 0.0;
    for (int v = 0; v < p.rows(); ++v) {
        const int column = v % 49, row = v / 49;
        if (p(v, 2) == 0 || column < 6 || column > 42 || row == 0 || row == 16)
            continue;
        const auto above = [&](int step) -> Vector3 {
            return (q.row(v) - 0.5 * (q.row(v + step) + q.row(v - step))).transpose();
        };
        const Vector3 along = (q.row(v + 1) - q.row(v - 1)).transpose(),
                      across = (q.row(v + 49) - q.row(v - 49)).transpose();
        const Vector3 normal = along.cross(across).normalized();
        worst = std::max(worst, (above(1) - above(3) / 9 - 0.05 * normal).norm());
        steepest = std::max(steepest, std::acos(normal.z()));
    }
    EXPECT_GT(steepest, 1.0);
    EXPECT_LT(worst, 0.01) << "a fifth; details that keep their directions are wrong by 0.05 here";
}

TEST_F(HierarchicalSmoothing, handles_of_other_parts_do_not_count)
{
    const SurfaceMesh mesh = shapes::hill(8, 8), both = shapes::joined(mesh, mesh, {0, 20, 0});
    const int n = mesh.vertex_count();
    std::vector<Handle> more = shapes::ends(mesh, 1.5);
    more.push_back({{n + 3, n + 40}, {}});
    const Poses poses{bent[0], bent[1], shapes::turn({1, 0, 1}, 140)};
    // With no levels: the number of vertices that are enough is one for all parts.
    EXPECT_LT(shapes::distance(solved(both, more, {.poses = poses}, {.levels = 0}).topRows(n),
                               solved(mesh, shapes::ends(mesh, 1.5), {.poses = bent}, {.levels = 0})),
              1e-9);
}

TEST_F(HierarchicalSmoothing, a_hierarchy_above_the_memory_limit_is_refused)
{
    const SurfaceMesh mesh = shapes::hill(40, 30);
    Method smoothing = bound(mesh, {}, shapes::ends(mesh, 1.5));
    const Points before = solve(smoothing, bent).positions;
    const MemoryLimit limit(100'000);
    EXPECT_THROW(smoothing.set_handles(shapes::ends(mesh, 2.5)), OutOfMemory);
    EXPECT_EQ(solve(smoothing, bent).positions, before);
}

} // namespace sinew::test_hierarchical_smoothing
