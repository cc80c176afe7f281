// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/surface_mesh.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <limits>

// Cuts, parts and other refusals are in tests/bindings/surfaces/test_surface_meshes.py and test_errors.py.
namespace sinew::test_surface_mesh {

TEST(SurfaceMesh, cuts_a_face_of_k_corners_into_k_minus_2_triangles_and_has_its_edges_without_the_cuts)
{
    const SurfaceMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 2, 0}, {-1, 1, 0}},
                                          {{0, 1, 2}, {0, 2, 3, 4}, {0, 1, 2, 3, 4, 5}});
    EXPECT_EQ(mesh.triangle_faces(), (std::vector{0, 1, 1, 2, 2, 2, 2}));
    EXPECT_EQ(mesh.triangles()[0], (Triangle{0, 1, 2}));
    const auto edges = shapes::quad_grid(1, 1).edges();
    EXPECT_EQ(edges, (std::vector<std::array<int, 2>>{{0, 1}, {0, 2}, {1, 3}, {2, 3}}));
    EXPECT_TRUE(shapes::mesh({{0, 0, 0}}, {}).edges().empty());
}

TEST(SurfaceMesh, refuses_counts_and_indices_that_no_array_of_python_has)
{
    const std::vector<Vector3> corner{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    constexpr int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
    refusal<InvalidMesh>(
        [&] { SurfaceMesh(shapes::points_of(corner), std::vector<int>(3, most), {0, 1, 2}); });
    for (int bad : {most, least})
        expect_elements(refusal<InvalidMesh>([&] { shapes::mesh(corner, {{0, 1, 2}, {0, 1, bad}}); }),
                        Error::Element::face, {1});
}

} // namespace sinew::test_surface_mesh
