// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/spline_grid.h"

#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

namespace sinew::test_spline_grid {

std::vector<SplineGrid::Stencil> scattered(const SplineGrid& grid, int count, std::uint64_t seed)
{
    shapes::Random random(seed);
    std::vector<SplineGrid::Stencil> stencils;
    for (int k = 0; k < count; ++k) {
        const double u = random.unit();
        stencils.push_back(grid.stencil(u, random.unit()));
    }
    return stencils;
}

TEST(SplineGrid, moves_by_one_point_only_the_stated_rectangle_of_degree_plus_one_spans)
{
    for (int degree = 1; degree <= 5; ++degree) {
        const SplineGrid grid(degree, 11, 9);
        const int i = 6, j = 5;
        RowMatrix control = RowMatrix::Zero(grid.size(), 1);
        control(j * grid.columns() + i, 0) = 1.0;
        const auto [u0, u1] = grid.along_u().support(i);
        const auto [v0, v1] = grid.along_v().support(j);
        EXPECT_NEAR(u1 - u0, (degree + 1.0) / (11 - degree), 1e-15);
        EXPECT_NEAR(v1 - v0, (degree + 1.0) / (9 - degree), 1e-15);
        for (double u = 0.0005; u < 1; u += 0.013)
            for (double v = 0.0005; v < 1; v += 0.013) {
                double moved = -1.0;
                grid.evaluate(grid.stencil(u, v), control, &moved);
                const bool inside = u > u0 && u < u1 && v > v0 && v < v1;
                EXPECT_EQ(moved > 0, inside) << degree << " " << u << " " << v;
            }
    }
}

TEST(SplineGrid, costs_no_bending_where_the_points_move_by_a_linear_function)
{
    for (int degree : {1, 3, 5}) {
        const SplineGrid grid(degree, 7, 8);
        const MatrixX form = grid.bending();
        EXPECT_LT((form - form.transpose()).norm(), 1e-15);
        VectorX linear(grid.size()), square(grid.size());
        for (int j = 0; j < grid.rows(); ++j)
            for (int i = 0; i < grid.columns(); ++i) {
                linear[j * grid.columns() + i] = 1 + 2 * grid.along_u().place(i) - grid.along_v().place(j);
                square[j * grid.columns() + i] = i * i;
            }
        EXPECT_LT((form * linear).norm(), 1e-12);
        EXPECT_NEAR(square.dot(form * square), 4.0 * (grid.columns() - 2) * grid.rows(), 1e-9);
        const VectorX values = dense::eigenvalues(form);
        EXPECT_GT(values[3], 1e-6);
        EXPECT_LT(values[2], 1e-12) << "three functions: 1, u, v";
    }
}

TEST(ControlFit, with_a_penalty_is_least_and_reproduces_linear_functions)
{
    const SplineGrid grid(3, 7, 6);
    const std::vector<SplineGrid::Stencil> stencils = scattered(grid, 40, 9);
    const ControlFit fit(grid.weights(stencils), VectorX::Ones(40), grid.bending(), 1e-2);
    MatrixX lines(grid.size(), 2);
    for (int j = 0; j < grid.rows(); ++j)
        for (int i = 0; i < grid.columns(); ++i)
            lines.row(j * grid.columns() + i) << 3.0, grid.along_u().place(i) - 2 * grid.along_v().place(j);
    const MatrixX B = MatrixX(grid.weights(stencils));
    // The least norm pulls by 1e-8, and N by 1e-3 or more.
    EXPECT_LT((fit.solve(B * lines) - lines).norm(), 1e-4);
    const MatrixX d = shapes::Random(10).dense(40, 2);
    const MatrixX c = fit.solve(d), slope = B.transpose() * (B * c - d) / 40 + 1e-2 * grid.bending() * c;
    EXPECT_LT(slope.norm(), 1e-7);
}

TEST(ControlFit, equal_wishes_move_all_points_alike)
{
    const SplineGrid grid(3, 6, 6);
    {
        const MemoryLimit limit(1000);
        EXPECT_THROW(ControlFit(grid.weights(scattered(grid, 4, 1)), VectorX::Ones(4), MatrixX(), 0.0),
                     OutOfMemory);
    }
    for (double smoothing : {0.0, 1e-3})
        for (int count : {1, 3, 200}) {
            const ControlFit fit(grid.weights(scattered(grid, count, 3)), VectorX::Ones(count),
                                 grid.bending(), smoothing);
            const RowMatrix c = fit.solve(MatrixX::Constant(count, 1, 2.5));
            EXPECT_LT((c.array() - 2.5).abs().maxCoeff(), 1e-7) << count; // rounding over a pull of 1e-8
        }
}

} // namespace sinew::test_spline_grid
