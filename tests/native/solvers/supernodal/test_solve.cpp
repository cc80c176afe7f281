// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/simd/kernel_set.h"
#include "native/solvers/supernodal/kernels.h"
#include "native/solvers/supernodal/solve.h"
#include "tests/native/dense.h"
#include "tests/native/shapes.h"

#include <algorithm>
#include <random>
#include <vector>

namespace sinew::test_solve {
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
            std::vector<int> own = shapes::numbers(first[s], first[s + 1]);
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
        values.resize(values.size() + SupernodalFactor::padding, 12345.0);
        permutation = shapes::Random(seed).shuffled(n);
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
        MatrixX result = rhs;
        result(permutation, Eigen::all) =
            dense::solution(dense::product(L, L.transpose()), rhs(permutation, Eigen::all));
        return result;
    }
};

TEST(SupernodalSolve, equals_a_dense_solve_for_one_to_four_columns)
{
    // Widths around the kernels' four columns and the inverted blocks' sixteen.
    for (const std::vector<int>& widths :
         {std::vector{1}, {1, 1, 1}, {3, 5, 4}, {16, 17, 15}, {33, 2, 48, 1}, {64}}) {
        Example example(widths, 0.4, 7);
        const SupernodalSolve solve(example.view());
        for (int k = 1; k <= lane_count; ++k) {
            const MatrixX rhs = MatrixX::Random(example.permutation.size(), k);
            const MatrixX expected = example.expected(rhs);
            MatrixX found;
            solve.solve(rhs, found);
            ASSERT_EQ(found.cols(), k);
            EXPECT_LT((found - expected).norm(), 1e-11 * expected.norm()) << widths[0];
        }
    }
}

/// A supernode with random numbers, and what stands for its inverse triangles.
struct RandomSupernode
{
    int width, height;
    MatrixX values;
    VectorX diagonal;
    std::vector<int> rows; ///< every second point behind its own

    RandomSupernode(int width, int height)
        : width(width), height(height), values(MatrixX::Random(height, width + 8)), // read past the end
          diagonal(VectorX::Random(width))
    {
        for (int r = width; r < height; ++r)
            rows.push_back(width + 2 * (r - width));
    }
    int points() const { return 2 * height; }
    /// The triangles' inverses where the kernels expect them.
    MatrixX inverse(int c, int part) const
    {
        MatrixX T = values.block(c, c, part, part).transpose().triangularView<Eigen::StrictlyLower>();
        T.diagonal() = diagonal.segment(c, part);
        return T;
    }
    void forward(MatrixX& x) const
    {
        for (int c = 0; c < width; c += 16) {
            const int part = std::min(16, width - c);
            x.middleRows(c, part) = dense::product(inverse(c, part), x.middleRows(c, part));
            for (int r = c + part; r < height; ++r)
                x.row(place(r)) -= dense::product(values.block(r, c, 1, part), x.middleRows(c, part));
        }
    }
    void backward(MatrixX& x) const
    {
        for (int c = (width - 1) / 16 * 16; c >= 0; c -= 16) {
            const int part = std::min(16, width - c);
            for (int r = c + part; r < height; ++r)
                x.middleRows(c, part) -=
                    dense::product(values.block(r, c, 1, part).transpose(), x.row(place(r)));
            x.middleRows(c, part) = dense::product(inverse(c, part).transpose(), x.middleRows(c, part));
        }
    }
    int place(int r) const { return r < width ? r : rows[r - width]; }
};

/// By the kernels: forward, with the rows from `inside` on in an array of their own, or backward.
template <class T>
MatrixX run(const LaneKernels<T>& kernels, const RandomSupernode& s, const MatrixX& x, int lanes,
            bool forward, int inside)
{
    const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> values = s.values.cast<T>();
    const Eigen::Matrix<T, Eigen::Dynamic, 1> diagonal = s.diagonal.cast<T>();
    const LaneSupernode<T> view{values.data(), diagonal.data(), s.rows.data(), s.width, s.height};
    Eigen::Matrix<T, lane_count, Eigen::Dynamic> points = x.transpose().cast<T>(), sums = points;
    std::vector<T> workspace(LaneSupernode<T>::workspace(s.height));
    std::vector<int> place = shapes::numbers(0, s.points());
    std::ranges::reverse(place);
    if (!forward) {
        kernels.backward(view, lanes, points.data(), points.data(), workspace.data());
        return points.transpose().template cast<double>();
    }
    sums.setZero();
    kernels.forward(view, lanes, points.data(), points.data(), inside, sums.data(), place.data(),
                    workspace.data());
    for (int k = 0; k < s.points(); ++k)
        points.col(k) += sums.col(place[k]);
    return points.transpose().template cast<double>();
}

template <class T>
void expect_kernels(double tolerance)
{
    const LaneKernels<T>& plain = LaneKernels<T>::baseline;
    const LaneKernels<T>* wide = kernels_with<LaneKernels<T>>(Instructions::avx2);
    for (const int lanes : {3, 4})
        for (const int width : {1, 2, 3, 4, 7, 8, 16, 17, 35, 50})
            for (const int rest : {0, 1, 3, 8, 21})
                for (const bool forward : {true, false}) {
                    const RandomSupernode s(width, width + rest);
                    MatrixX x = MatrixX::Random(s.points(), lane_count);
                    if (lanes == 3)
                        x.col(3).setZero();
                    MatrixX expected = x;
                    forward ? s.forward(expected) : s.backward(expected);
                    for (const int inside : {0, width + 9, s.points()}) {
                        const MatrixX a = run(plain, s, x, lanes, forward, inside);
                        const double scale = 1 + expected.norm();
                        EXPECT_LT((a - expected).norm(), tolerance * scale) << width << '+' << rest;
                        if (wide) {
                            EXPECT_EQ(a, run(*wide, s, x, lanes, forward, inside)) << width << '+' << rest;
                        }
                    }
                }
}

TEST(Lanes, substitute_as_dense_triangles_do_and_to_the_same_bits_with_wide_instructions)
{
    expect_kernels<double>(1e-13); // some 50 terms a sum
    expect_kernels<float>(5e-5);
}

} // namespace sinew::test_solve
