// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/constrained_quadratic.h"

#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/solvers/matrices.h"

#include <memory>

namespace sinew::test_constrained_quadratic {

/// The minimiser from the dense saddle-point system [A C^T; C 0].
MatrixX dense_kkt(const SparseMatrix& A, const std::vector<bool>& free, const MatrixX& given,
                  const MatrixX& b)
{
    const int n = static_cast<int>(A.rows());
    std::vector<int> fixed;
    for (int i = 0; i < n; ++i)
        if (!free[i])
            fixed.push_back(i);
    const int m = static_cast<int>(fixed.size());
    MatrixX K = MatrixX::Zero(n + m, n + m);
    K.topLeftCorner(n, n) = A;
    MatrixX rhs(n + m, given.cols());
    rhs.topRows(n) = b;
    for (int k = 0; k < m; ++k) {
        K(n + k, fixed[k]) = K(fixed[k], n + k) = 1;
        rhs.row(n + k) = given.row(fixed[k]);
    }
    return dense::solution(K, rhs).topRows(n);
}

std::shared_ptr<const SparseMatrix> kept(const SparseMatrix& A) { return std::make_shared<SparseMatrix>(A); }

// Condition below 1e4 in all of these.
constexpr double tolerance = 1e-11;

TEST(ConstrainedQuadratic, minimises_as_the_dense_saddle_point_system_does)
{
    shapes::Random random(1);
    for (int trial = 0; trial < 20; ++trial) {
        const int n = 10 + trial * 4;
        const SparseMatrix A = matrices::random_spd(n, trial);
        std::vector<bool> free(n);
        for (int i = 0; i < n; ++i)
            free[i] = random.unit() < 0.7;
        const MatrixX given = random.dense(n, 3);
        const RowMatrix b = random.dense(n, 3);
        ConstrainedQuadratic system;
        system.factorize(kept(A), free);

        RowMatrix x = given;
        const RowMatrix side = system.right_side(x, &b);
        const std::vector<int>& rows = system.problem().unknowns;
        system.solve(x, &b);
        EXPECT_LT(dense::largest(x - dense_kkt(A, free, given, b)), tolerance);
        MatrixX others = given;
        others(rows, Eigen::all).setZero();
        const MatrixX load = MatrixX(b) - A * others, expected = load(rows, Eigen::all);
        EXPECT_LT(dense::largest(side - expected), 1e-13); // the same products in another order

        x = given;
        x(rows, Eigen::all).setConstant(1e30); // which it does not read
        system.solve(x);
        EXPECT_LT(dense::largest(x - dense_kkt(A, free, given, MatrixX::Zero(n, 3))), tolerance);
        for (int i = 0; i < n; ++i)
            EXPECT_TRUE(free[i] || x.row(i) == given.row(i)) << "not to the bit";
    }
}

TEST(ConstrainedQuadratic, names_a_row_of_the_whole_matrix_where_it_breaks_down)
{
    const SparseMatrix A = matrices::diagonal({1, 1, 1, 0, 1});
    ConstrainedQuadratic system;
    const auto factorize = [&] { system.factorize(kept(A), {false, false, true, true, true}); };
    expect_elements(refusal<FactorizationFailed>(factorize), Error::Element::vertex, {3});
}

} // namespace sinew::test_constrained_quadratic
