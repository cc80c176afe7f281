// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/single_factor.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/solvers/matrices.h"
#include "tests/native/threads.h"

namespace sinew::test_single_factor {

TEST(SingleFactor, solves_to_single_precision_and_twice_to_its_square_however_large_the_right_side_is)
{
    const SparseMatrix A = matrices::shuffled_grid(60);
    SingleFactor factor;
    factor.factorize(A);
    for (int columns : {1, 3, 4}) {
        const MatrixX rhs = MatrixX::Random(A.rows(), columns), x = dense::solution(A, rhs);
        MatrixX found, left;
        factor.solve(rhs, found);
        EXPECT_LT((found - x).norm(), 1e-4 * x.norm()); // its condition is 800
        factor.solve(rhs - A * found, left);
        EXPECT_LT((found + left - x).norm(), 1e-8 * x.norm());
        for (double scale : {1e-200, 1e200}) { // far beyond floats
            factor.solve(scale * rhs, left);
            EXPECT_LT((left / scale - found).norm(), 1e-5 * found.norm());
        }
        factor.solve(0.0 * rhs, left);
        EXPECT_EQ(dense::largest(left), 0.0);
    }
    const MatrixX rhs = MatrixX::Random(A.rows(), 3);
    Points points = rhs;
    factor.solve(points, points);
    EXPECT_LT((points - dense::solution(A, rhs)).norm(), 1e-4 * points.norm()) << "in place";
}

TEST(SingleFactor, eliminates_every_unknown_once_and_takes_new_names)
{
    const SparseMatrix A = matrices::shuffled_grid(20);
    const int n = static_cast<int>(A.rows());
    SingleFactor factor;
    factor.factorize(A);
    std::vector<int> order = factor.order(), names = shapes::numbers(0, n);
    std::ranges::sort(order);
    EXPECT_EQ(order, names);
    std::ranges::reverse(names);
    const MatrixX rhs = MatrixX::Random(n, 3);
    MatrixX before, after;
    factor.solve(rhs, before);
    factor.rename(names);
    factor.solve(rhs.colwise().reverse(), after);
    EXPECT_EQ(MatrixX(after.colwise().reverse()), before);
}

TEST(SingleFactor, is_ordered_as_fits_its_size)
{
    if (!have_cholmod())
        GTEST_SKIP() << "this build has no CHOLMOD";
    for (const auto& [side, ordering] : {std::pair(224, Ordering::patch_dissection),
                                         {100, Ordering::nested_dissection},
                                         {99, Ordering::minimum_degree}}) {
        const SparseMatrix A = matrices::shuffled_grid(side);
        EXPECT_EQ(fill_reducing_order(A), elimination_order(A, ordering)) << side;
    }
}

TEST(SingleFactor, gives_the_same_bits_on_any_number_of_threads)
{
    const SparseMatrix A = matrices::shuffled_grid(250); // enough for several subtrees
    SingleFactor factor;
    factor.factorize(A);
    const MatrixX rhs = MatrixX::Random(A.rows(), 3);
    const auto solved = [&] {
        MatrixX x;
        factor.solve(rhs, x);
        return x;
    };
    const MatrixX many = solved();
    {
        const ThreadLimit limit(1);
        EXPECT_EQ(solved(), many);
    }
    expect_in_threads(4, 1, solved, many);
}

TEST(SingleFactor, takes_half_the_memory)
{
    const SparseMatrix A = matrices::shuffled_grid(100);
    SingleFactor single;
    single.factorize(A);
    SpdFactor twice({.backend = FactorBackend::automatic, .ordering = Ordering::nested_dissection});
    twice.factorize(A);
    EXPECT_GT(single.bytes(), 0);
    EXPECT_LT(single.bytes(), twice.bytes());
}

TEST(SingleFactor, refuses_a_singular_matrix_and_of_nothing_solves_nothing)
{
    SingleFactor factor;
    EXPECT_THROW(factor.factorize(matrices::shuffled_grid(10, 0.0)), FactorizationFailed);
    factor.factorize(SparseMatrix(0, 0));
    Points none(0, 3);
    factor.solve(none, none);
    EXPECT_EQ(none.rows(), 0);
}

} // namespace sinew::test_single_factor
