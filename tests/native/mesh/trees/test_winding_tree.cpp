// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/winding_tree.h"

#include "tests/native/shapes.h"

namespace sinew::test_winding_tree {

/// The largest difference from the sum over all triangles, at points in and around the mesh.
double worst_error(const SurfaceMesh& mesh, const std::vector<Triangle>& triangles, int count)
{
    const std::vector<Vector3> points = shapes::list_of(mesh.points());
    const WindingTree tree(points, triangles);
    const Vector3 low = mesh.points().colwise().minCoeff(), high = mesh.points().colwise().maxCoeff();
    shapes::Random random(4);
    double worst = 0.0;
    for (int k = 0; k < count; ++k) {
        const Vector3 at = 0.5 * (low + high) + 0.7 * (high - low).cwiseProduct(random.vector());
        worst = std::max(worst, std::abs(tree.at(at) - winding_number(points, triangles, at)));
    }
    return worst;
}

TEST(WindingTree, agrees_with_the_sum_over_all_triangles)
{
    for (const SurfaceMesh& mesh :
         {shapes::sphere(4), shapes::bar(40, 6), shapes::hill(50, 40), shapes::messy()})
        EXPECT_LT(worst_error(mesh, mesh.triangles(), 2000), 0.02);
    const SurfaceMesh sphere = shapes::sphere(4);
    std::vector<Triangle> open(sphere.triangles().begin(), sphere.triangles().begin() + 1500);
    EXPECT_LT(worst_error(sphere, open, 2000), 0.02) << "with a hole";
}

TEST(WindingTree, does_not_mind_the_size_of_the_mesh)
{
    EXPECT_EQ(WindingTree({{0, 0, 0}}, {}).at({1, 0, 0}), 0.0) << "without triangles";
    const SurfaceMesh sphere = shapes::sphere(3);
    for (double scale : {1e-60, 1.0, 1e59}) {
        std::vector<Vector3> points = shapes::list_of(sphere.points());
        for (Vector3& p : points)
            p *= scale;
        const WindingTree tree(points, sphere.triangles());
        EXPECT_NEAR(tree.at({0.1 * scale, 0, 0.2 * scale}), 1.0, 0.02) << scale;
        EXPECT_NEAR(tree.at({0, -3 * scale, 0}), 0.0, 0.02) << scale;
    }
}

} // namespace sinew::test_winding_tree
