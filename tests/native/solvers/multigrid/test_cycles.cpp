// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/multigrid/cycles.h"

#include "native/solvers/systems/conjugate_gradients.h"
#include "tests/native/solvers/matrices.h"

#include <stdexcept>

namespace sinew::test_cycles {

constexpr int side = 150;

/// The bi-Laplacian of a square grid, each node pulled a little.
LinearSystem grid()
{
    LinearSystem system;
    system.graph = matrices::shuffled_grid(side, 0.0);
    system.points = matrices::points_of_shuffled_grid(side);
    const auto n = static_cast<int>(system.graph.cols());
    system.mass = VectorX::Ones(n);
    system.order = 2;
    system.pulls = VectorX::Constant(n, 1e-4);
    system.vertices = shapes::numbers(0, n);
    return system;
}

/// Of the columns of `x` (n, 4), whose load is computed, and which the solution must be.
int iterations(const LinearSystem& system, const Hierarchy& hierarchy, int twice_from, const MatrixX& x)
{
    const MatrixX Lx = system.graph * x, b = system.graph * Lx + system.pulls.asDiagonal() * x;
    const auto row_of = [&](const MatrixX& from, int i) {
        return Eigen::Array4d(from.row(hierarchy.unknowns[i]).transpose().array());
    };
    const auto n = static_cast<int>(x.rows());
    Columns r(n), found(n, Eigen::Array4d::Zero());
    for (int i = 0; i < n; ++i)
        r[i] = hierarchy.scale * row_of(b, i);
    const Eigen::Array4d load = hierarchy.scale * b.colwise().norm().transpose().array();
    Cycles cycles(hierarchy, twice_from);
    const auto multiply = [&](const Columns& from, Columns& to) { cycles.multiply(from, {}, to); };
    const auto precondition = [&](const Columns& from, Columns& to) {
        for (int i = 0; i < n; ++i)
            cycles.right_side()[i] = from[i].cast<float>();
        if (const std::vector<Wide>* const step = cycles.cycle())
            to = *step;
        else
            throw std::runtime_error("the cycle is not positive definite");
    };
    const Stop stop{.tolerance = 1e-5, .most_iterations = 100, .measure = Measure::remaining};
    const Iteration done = conjugate_gradients(n, multiply, load, r, found, precondition, stop, {});
    EXPECT_TRUE(done.converged);
    for (int i = 0; i < n; ++i)
        EXPECT_LT((found[i] - row_of(x, i)).abs().maxCoeff(), 1e-4);
    return done.count;
}

TEST(Cycles, that_visit_coarse_levels_twice_need_fewer_iterations_for_the_same_solution)
{
    const LinearSystem system = grid();
    const Hierarchy hierarchy(system);
    ASSERT_GE(hierarchy.levels.size(), 3U) << "the coarsest level is solved at once";
    MatrixX x(side * side, 4);
    for (int k = 0; k < 4; ++k)
        x.col(k) = ((k + 1) * shapes::pi / side * system.points.col(k % 2).array()).cos();
    EXPECT_LT(iterations(system, hierarchy, 1, x), iterations(system, hierarchy, Cycles::never, x));
}

} // namespace sinew::test_cycles
