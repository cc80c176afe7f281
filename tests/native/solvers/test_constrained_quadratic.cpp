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

std::vector<bool> random_choice(shapes::Random& random, int n, double share)
{
    std::vector<bool> free(n);
    for (int i = 0; i < n; ++i)
        free[i] = random.unit() < share;
    return free;
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
        const std::vector<bool> free = random_choice(random, n, 0.7);
        const MatrixX given = random.dense(n, 3);
        const RowMatrix b = random.dense(n, 3);
        ConstrainedQuadratic system;
        system.factorize(kept(A), free);

        RowMatrix x = given;
        system.solve(x, &b);
        EXPECT_LT((x - dense_kkt(A, free, given, b)).cwiseAbs().maxCoeff(), tolerance);

        x = given;
        system.solve(x);
        EXPECT_LT((x - dense_kkt(A, free, given, MatrixX::Zero(n, 3))).cwiseAbs().maxCoeff(), tolerance);
        for (int i = 0; i < n; ++i)
            EXPECT_TRUE(free[i] || x.row(i) == given.row(i)) << "not to the bit";
    }
}

TEST(ConstrainedQuadratic, needs_only_the_free_block_to_be_definite)
{
    const SparseMatrix L = matrices::shuffled_grid(6, 0.0); // constants cost nothing
    std::vector<bool> free(36, true);
    free[5] = false;
    ConstrainedQuadratic system;
    system.factorize(kept(L), free);
    RowMatrix x = MatrixX::Zero(36, 1);
    x(5) = 7;
    system.solve(x);
    EXPECT_LT((x.array() - 7).abs().maxCoeff(), tolerance);
}

TEST(ConstrainedQuadratic, does_not_read_what_stands_in_the_unknowns)
{
    const SparseMatrix A = matrices::random_spd(20, 4);
    std::vector<bool> free(20, true);
    free[0] = free[7] = false;
    ConstrainedQuadratic system;
    system.factorize(kept(A), free);
    RowMatrix x = MatrixX::Ones(20, 1);
    RowMatrix y = MatrixX::Constant(20, 1, 1e30);
    y(0) = y(7) = 1;
    system.solve(x);
    system.solve(y);
    EXPECT_EQ(x, y);
}

TEST(ConstrainedQuadratic, forms_the_right_side_that_it_solves_for)
{
    shapes::Random random(5);
    const SparseMatrix A = matrices::random_spd(25, 5);
    const std::vector<bool> free = random_choice(random, 25, 0.6);
    ConstrainedQuadratic system;
    system.factorize(kept(A), free);
    RowMatrix x = random.dense(25, 2);
    const RowMatrix b = random.dense(25, 2);
    const RowMatrix side = system.right_side(x, &b);
    const std::vector<int>& rows = system.problem().unknowns;
    ASSERT_EQ(side.rows(), static_cast<Eigen::Index>(rows.size()));
    MatrixX given = x;
    given(rows, Eigen::all).setZero();
    const MatrixX load = MatrixX(b) - A * given, expected = load(rows, Eigen::all);
    EXPECT_LT(dense::largest(side - expected), 1e-13); // the same products in another order
}

TEST(ConstrainedQuadratic, with_everything_given_solves_nothing)
{
    const SparseMatrix A = matrices::random_spd(5, 6);
    ConstrainedQuadratic system;
    system.factorize(kept(A), std::vector<bool>(5, false));
    RowMatrix x = MatrixX::Ones(5, 3);
    system.solve(x);
    EXPECT_EQ(x, RowMatrix::Ones(5, 3));
}

TEST(ConstrainedQuadratic, names_a_row_of_the_whole_matrix_where_it_breaks_down)
{
    const SparseMatrix A = matrices::diagonal({1, 1, 1, 0, 1});
    ConstrainedQuadratic system;
    const auto factorize = [&] { system.factorize(kept(A), {false, false, true, true, true}); };
    expect_elements(refusal<FactorizationFailed>(factorize), Error::Element::vertex, {3});
}

TEST(ConstrainedQuadratic, ten_solves_take_one_factorisation)
{
    ConstrainedQuadratic system;
    std::vector<bool> free(36, true);
    free[0] = false;
    system.factorize(kept(matrices::shuffled_grid(6)), free);
    for (int k = 0; k < 10; ++k) {
        RowMatrix x = MatrixX::Constant(36, 1, k);
        system.solve(x);
    }
    EXPECT_EQ(system.factor().factorizations(), 1);
    EXPECT_EQ(system.factor().analyses(), 1);
}

} // namespace sinew::test_constrained_quadratic
