// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/flat_outline.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

namespace sinew::test_flat_outline {

TEST(FlatOutline, of_a_grid_is_its_border_with_holes_and_parts)
{
    const SurfaceMesh ring = shapes::without_face(shapes::quad_grid(3, 3), 4); // the middle
    EXPECT_EQ(flat_outline(ring)->edges.size(), 16u);
    EXPECT_EQ(flat_outline(shapes::joined(ring, ring, {5, 0, 0}))->edges.size(), 32u);
    const SurfaceMesh grid = shapes::quad_grid(4, 3);
    const auto outline = flat_outline(grid);
    ASSERT_TRUE(outline);
    EXPECT_EQ(outline->edges.size(), 14u);
    EXPECT_NEAR(outline->normal.z(), 1.0, 1e-15);
    double area = 0.0; // counter-clockwise
    for (const auto& [a, b] : outline->edges)
        area += 0.5 * grid.point(a).cross(grid.point(b)).z();
    EXPECT_NEAR(area, 12.0, 1e-12);
}

TEST(FlatOutline, is_none_of_what_is_not_flat)
{
    EXPECT_FALSE(flat_outline(shapes::cube()));
    EXPECT_FALSE(flat_outline(shapes::hill(4, 4)));
    Points flat = shapes::cube().points();
    flat.col(2).setZero();
    EXPECT_FALSE(flat_outline(shapes::moved(shapes::cube(), flat)));
    Points bent = shapes::quad_grid(3, 3).points();
    bent(5, 2) += 1e-3;
    EXPECT_FALSE(flat_outline(shapes::moved(shapes::quad_grid(3, 3), bent)));
}

TEST(FlatOutline, names_what_crosses_touches_or_looks_back)
{
    // Two squares at one corner.
    const SurfaceMesh grid = shapes::quad_grid(2, 2);
    const shapes::Polygons faces = shapes::faces_of(grid);
    const SurfaceMesh touching = shapes::over(grid.points(), {faces[0], faces[3]});
    const SurfaceMesh bow =
        shapes::mesh({{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {1, -1, 0}, {0, 2, 0}}, {{0, 1, 2, 3, 4}});
    const auto expect_refused = [](const SurfaceMesh& mesh, const std::vector<int>& vertices) {
        expect_elements(refusal<InvalidMesh>([&] { flat_outline(mesh); }), Error::Element::vertex, vertices);
    };
    expect_refused(touching, {4});
    expect_refused(shapes::flipped(grid, {0}), {1, 3, 4});
    expect_refused(bow, {0, 1, 2, 3, 4});
}

} // namespace sinew::test_flat_outline
