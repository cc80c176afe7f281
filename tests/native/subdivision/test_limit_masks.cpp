// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/limit_masks.h"

#include "native/subdivision/subdivision_surface.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_limit_masks {

namespace {

Points refined(const SurfaceMesh& mesh, SubdivisionOptions options, int level, bool limit)
{
    options.level = level;
    options.limit = limit;
    const SubdivisionSurface surface(mesh, options);
    Points result(surface.vertex_count(), 3);
    surface.refine(mesh.points().data(), result.data());
    return result;
}

} // namespace

// E. Halstead et al. 1993 for quads, C. Loop 1987 for triangles.
TEST(LimitMasks, are_the_published_ones_where_nothing_is_sharp)
{
    for (int n : {3, 4, 5, 8}) {
        const auto quads = limit_mask({false, n, 0.0, std::vector<double>(n, 0.0)});
        ASSERT_EQ(quads.size(), 1u + 2 * n);
        EXPECT_NEAR(quads[0], n / (n + 5.0), 1e-13);
        EXPECT_NEAR(quads[1], 4.0 / (n * (n + 5.0)), 1e-13);
        EXPECT_NEAR(quads[1 + n], 1.0 / (n * (n + 5.0)), 1e-13);

        const auto triangles = limit_mask({true, n, 0.0, std::vector<double>(n, 0.0)});
        const double c = 0.375 + 0.25 * std::cos(2 * shapes::pi / n), beta = (0.625 - c * c) / n;
        ASSERT_EQ(triangles.size(), 1u + n);
        EXPECT_NEAR(triangles[0], 1.0 / (1.0 + 8.0 * n * beta / 3.0), 1e-13);
    }
}

TEST(LimitMasks, of_creases_borders_and_corners_are_those_of_curves)
{
    const std::vector<double> crease{10, 0, 10, 0};
    EXPECT_EQ(limit_mask({true, 4, 0.0, crease}), (std::vector<double>{2. / 3, 1. / 6, 0, 1. / 6, 0}));
    const auto border = limit_mask({false, 2, 0.0, {10, 0, 10}});
    EXPECT_NEAR(border[0], 2.0 / 3, 1e-15);
    EXPECT_NEAR(border[1] + border[3], 1.0 / 3, 1e-15);
    EXPECT_EQ(limit_mask({false, 4, 10.0, {0, 0, 0, 0}})[0], 1.0);
    EXPECT_EQ(limit_mask({false, 4, 0.0, {10, 10, 10, 0}})[0], 1.0);
}

// What OpenSubdiv's own rules give far down: the end of an endless crease, and sharpness of every kind that
// is left.
TEST(LimitMasks, are_where_many_levels_lead)
{
    constexpr int deep = 7;
    for (bool triangles : {false, true}) {
        const SurfaceMesh mesh = triangles ? shapes::octahedron() : shapes::cube();
        SubdivisionOptions options;
        options.scheme = triangles ? SubdivisionScheme::loop : SubdivisionScheme::catmull_clark;
        const auto edge = [&](int face, int k, double sharpness) {
            options.crease_edges.push_back({mesh.face(face)[k], mesh.face(face)[k + 1]});
            options.crease_sharpness.push_back(sharpness);
        };
        edge(0, 0, 10.0);
        edge(1, 0, 3.3);
        edge(1, 1, 1.5);
        edge(3, 1, 0.4);
        options.corner_vertices = {mesh.face(1)[2]};
        options.corner_sharpness = {2.7};
        const Points far = refined(mesh, options, deep, false),
                     farther = refined(mesh, options, deep + 1, false);
        for (int level : {0, 1, 2}) {
            const Points limit = refined(mesh, options, level, true);
            const auto n = limit.rows();
            const double left = shapes::distance(limit, farther.topRows(n));
            // What is left shrinks by a factor of at most 0.7 a level (valence 5 or less): from the last two
            // levels.
            EXPECT_LT(left, 0.7 / 0.3 * shapes::distance(far.topRows(n), farther.topRows(n)) + 1e-14);
            EXPECT_LT(left, 2e-3);
        }
    }
}

} // namespace sinew::test_limit_masks
