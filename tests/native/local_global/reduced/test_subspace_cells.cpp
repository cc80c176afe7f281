// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/reduced/subspace_cells.h"

#include "native/operators/laplacian.h"
#include "tests/native/differences.h"
#include "tests/native/shapes.h"

namespace sinew::test_subspace_cells {

// Its minimum is that of dense matrices in tests/bindings/oracles/test_oracles_reduced.py.
TEST(SubspaceCells, the_gradient_is_that_of_differences)
{
    const SurfaceMesh mesh = shapes::bar(10, 3);
    const int n = mesh.vertex_count();
    std::vector<int> seeds, labels;
    for (int v = 0; v < n; v += n / 40)
        seeds.push_back(v);
    // Hat functions of the distance from some vertices, so that the rows sum to 1.
    RowMatrix B(n, static_cast<Eigen::Index>(seeds.size()));
    for (int v = 0; v < n; ++v) {
        for (std::size_t k = 0; k < seeds.size(); ++k)
            B(v, static_cast<Eigen::Index>(k)) =
                std::exp(-0.5 * (mesh.point(v) - mesh.point(seeds[k])).squaredNorm());
        B.row(v) /= B.row(v).sum();
        labels.push_back(static_cast<int>(mesh.point(v).x() + 0.5) % 11);
    }
    const std::vector<Handle> ends = shapes::ends(mesh, 2);
    std::vector<SubspaceCells::Pull> pulls;
    for (int h : {0, 1})
        for (const int v : ends[h].vertices)
            pulls.push_back({h, v, 3.0});
    const SubspaceCells cells(B, laplacian_matrix(mesh, Discretization::cotan),
                              mass_vector(mesh, Discretization::cotan_voronoi), labels, 11, 0.3, pulls, 2);
    const Points y = mesh.points()(seeds, Eigen::all);
    const SubspaceCells::Base base = cells.base(y);
    std::vector<Points> aims;
    for (const Pose& pose : {shapes::still(), shapes::turn({1, 0.2, 0}, 100, {5, 1, 1}, {0, 1, 0})})
        aims.push_back(shapes::transformed(y, pose) - y);
    SubspaceProblem problem(cells, base, shapes::still(), aims);
    shapes::Random random(6);
    const Points u = 0.3 * random.dense(static_cast<int>(y.rows()), 3);
    Points gradient, other;
    problem.evaluate(u, gradient);
    for (int k = 0; k < 10; ++k) {
        const Points way = random.dense(static_cast<int>(y.rows()), 3);
        const auto along = [&](double s) { return problem.evaluate(u + s * way, other); };
        EXPECT_NEAR(central_difference(along, 1e-5), gradient.cwiseProduct(way).sum(),
                    1e-7 * gradient.norm() * way.norm());
    }
}

} // namespace sinew::test_subspace_cells
