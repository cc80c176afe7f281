// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/lanes.h"
#include "native/solvers/supernodal_solve.h"

#include "native/core/parallel.h"
#include "native/solvers/cholmod_factor.h"
#include "native/solvers/spd_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <random>
#include <thread>
#include <tuple>
#include <vector>

namespace sinew {
namespace {

/// A dense random lower triangle cut into supernodes of the given widths; entries below a supernode's own
/// columns are kept where `keep` says so, at least the first.
struct Example
{
    std::vector<int> permutation, first{0}, row_begin{0}, block_begin{0}, rows;
    std::vector<double> values;
    Eigen::MatrixXd L;

    Example(const std::vector<int>& widths, double density, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> value(-1.0, 1.0), chance(0.0, 1.0);
        for (const int width : widths)
            first.push_back(first.back() + width);
        const int n = first.back();
        L = Eigen::MatrixXd::Zero(n, n);
        for (std::size_t s = 0; s < widths.size(); ++s) {
            std::vector<int> own;
            for (int r = first[s]; r < first[s + 1]; ++r)
                own.push_back(r);
            for (int r = first[s + 1]; r < n; ++r)
                if (r == first[s + 1] || chance(random) < density)
                    own.push_back(r);
            const std::size_t start = values.size();
            values.resize(start + own.size() * widths[s], 12345.0); // what CHOLMOD leaves above the diagonal
            for (int c = 0; c < widths[s]; ++c)
                for (std::size_t r = c; r < own.size(); ++r) {
                    const bool diagonal = static_cast<int>(r) == c;
                    const double entry = diagonal ? 1.5 + value(random) : value(random) / n;
                    values[start + c * own.size() + r] = entry;
                    L(own[r], first[s] + c) = entry;
                }
            rows.insert(rows.end(), own.begin(), own.end());
            row_begin.push_back(static_cast<int>(rows.size()));
            block_begin.push_back(static_cast<int>(values.size()));
        }
        permutation.resize(n);
        for (int i = 0; i < n; ++i)
            permutation[i] = i;
        std::shuffle(permutation.begin(), permutation.end(), random);
    }

    SupernodalFactor view()
    {
        return {.size = static_cast<int>(permutation.size()),
                .supernodes = static_cast<int>(first.size()) - 1,
                .permutation = permutation.data(),
                .first = first.data(),
                .row_begin = row_begin.data(),
                .block_begin = block_begin.data(),
                .rows = rows.data(),
                .values = values.data()};
    }

    /// A dense solve that shares nothing with ours.
    MatrixX expected(const MatrixX& rhs) const
    {
        MatrixX permuted(rhs.rows(), rhs.cols());
        for (std::size_t i = 0; i < permutation.size(); ++i)
            permuted.row(i) = rhs.row(permutation[i]);
        const MatrixX solved = (L * L.transpose()).ldlt().solve(permuted);
        MatrixX result(rhs.rows(), rhs.cols());
        for (std::size_t i = 0; i < permutation.size(); ++i)
            result.row(permutation[i]) = solved.row(i);
        return result;
    }
};

class SupernodalSolveTest : public ::testing::TestWithParam<std::vector<int>>
{
};

TEST_P(SupernodalSolveTest, equals_a_dense_solve_for_one_to_four_columns)
{
    Example example(GetParam(), 0.4, 7);
    const SupernodalSolve solve(example.view());
    for (int k = 1; k <= lane_count; ++k) {
        const MatrixX rhs = MatrixX::Random(example.permutation.size(), k);
        MatrixX found;
        solve.solve(rhs, found);
        const MatrixX expected = example.expected(rhs);
        ASSERT_EQ(found.cols(), k);
        EXPECT_LT((found - expected).norm(), 1e-11 * expected.norm());
    }
}

// Widths around the kernels' four columns and the inverted blocks' sixteen.
INSTANTIATE_TEST_SUITE_P(widths, SupernodalSolveTest,
                         ::testing::Values(std::vector<int>{1}, std::vector<int>{1, 1, 1},
                                           std::vector<int>{3, 5, 4}, std::vector<int>{16, 17, 15},
                                           std::vector<int>{33, 2, 48, 1}, std::vector<int>{64}));

/// The square of a grid's Laplacian: its elimination tree branches, and its factor of over a million entries
/// is large enough for several subtrees.
SparseMatrix squared_grid(int side)
{
    std::vector<Eigen::Triplet<double>> entries;
    const auto tie = [&](int a, int b) {
        for (const auto& [row, column, value] :
             {std::tuple{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}})
            entries.emplace_back(row, column, value);
    };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            if (x + 1 < side)
                tie(y * side + x, y * side + x + 1);
            if (y + 1 < side)
                tie(y * side + x, (y + 1) * side + x);
        }
    for (int i = 0; i < side * side; ++i)
        entries.emplace_back(i, i, 0.1);
    SparseMatrix L(side * side, side * side);
    L.setFromTriplets(entries.begin(), entries.end());
    return L * L;
}

TEST(SupernodalSolve, in_parallel_equals_another_library_and_does_not_depend_on_the_number_of_threads)
{
    const SparseMatrix matrix = squared_grid(110);
    SpdFactor ours({.backend = FactorBackend::supernodal}), theirs({.backend = FactorBackend::ldlt});
    if (!have_cholmod())
        GTEST_SKIP() << "no supernodal factor without CHOLMOD";
    ours.factorize(matrix);
    theirs.factorize(matrix);
    ASSERT_GT(ours.nonzeros(), 400'000); // below, it would not run in parallel
    const MatrixX rhs = MatrixX::Random(matrix.cols(), 3);
    const MatrixX many = ours.solve(rhs), expected = theirs.solve(rhs);
    // The condition is about 6e3, so ten digits agree with ease.
    EXPECT_LT((many - expected).norm(), 1e-10 * expected.norm());
    limit_threads(1);
    const MatrixX one = ours.solve(rhs);
    limit_threads(0);
    EXPECT_EQ(many, one);
}

TEST(SupernodalSolve, several_threads_may_solve_at_once)
{
    Example example(std::vector<int>(40, 7), 0.5, 5);
    const SupernodalSolve solve(example.view());
    std::vector<MatrixX> rhs, found(6);
    for (int t = 0; t < 6; ++t)
        rhs.push_back(MatrixX::Random(example.permutation.size(), 1 + t % 4));
    std::vector<std::thread> threads;
    for (int t = 0; t < 6; ++t)
        threads.emplace_back([&, t] { solve.solve(rhs[t], found[t]); });
    for (std::thread& thread : threads)
        thread.join();
    for (int t = 0; t < 6; ++t) {
        const MatrixX expected = example.expected(rhs[t]);
        EXPECT_LT((found[t] - expected).norm(), 1e-11 * expected.norm());
    }
}

TEST(Lanes, the_wide_kernels_agree_with_the_plain_ones_to_the_last_bit)
{
    const LaneKernels<double>* wide = avx2_lane_kernels<double>();
    if (!wide)
        GTEST_SKIP() << "this processor has no AVX2";
    const LaneKernels<double>& plain = baseline_lane_kernels<double>();
    for (const int columns : {1, 2, 3, 4, 7, 16}) {
        const int height = 37;
        const MatrixX block = MatrixX::Random(height, columns);
        const MatrixX points = MatrixX::Random(lane_count, columns),
                      rows = MatrixX::Random(lane_count, height);
        MatrixX a = rows, b = rows;
        plain.subtract_product(block.data(), height, columns, height, points.data(), a.data());
        wide->subtract_product(block.data(), height, columns, height, points.data(), b.data());
        EXPECT_EQ(a, b);
        EXPECT_LT((a - (rows - points * block.transpose())).norm(), 1e-13);
        a = points, b = points;
        plain.subtract_transposed(block.data(), height, columns, height, rows.data(), a.data());
        wide->subtract_transposed(block.data(), height, columns, height, rows.data(), b.data());
        EXPECT_EQ(a, b);
        EXPECT_LT((a - (points - rows * block)).norm(), 1e-13);
        const MatrixX eight = MatrixX::Random(8, 3 + columns), factors = MatrixX::Random(3, columns);
        MatrixX c(8, 3), d(8, 3);
        plain.product_of_eight(eight.data(), columns, factors.data(), c.data());
        wide->product_of_eight(eight.data(), columns, factors.data(), d.data());
        EXPECT_EQ(c, d);
        EXPECT_LT((c - (eight.leftCols(3) + eight.rightCols(columns) * factors.transpose())).norm(), 1e-13);
        const VectorX diagonal = VectorX::Random(columns);
        a = points, b = points;
        plain.triangle(block.data(), height, columns, diagonal.data(), a.data());
        wide->triangle(block.data(), height, columns, diagonal.data(), b.data());
        EXPECT_EQ(a, b);
        a = points, b = points;
        plain.triangle_transposed(block.data(), height, columns, diagonal.data(), a.data());
        wide->triangle_transposed(block.data(), height, columns, diagonal.data(), b.data());
        EXPECT_EQ(a, b);
    }
}

} // namespace
} // namespace sinew
