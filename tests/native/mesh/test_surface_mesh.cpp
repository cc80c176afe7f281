// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/surface_mesh.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <limits>

// Cuts, edges, parts and other refusals are in tests/bindings/surfaces/test_surface_meshes.py and test_errors.py.
namespace sinew::test_surface_mesh {

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
