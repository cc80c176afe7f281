// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dense/system.h"

#include "native/solvers/dense/kernels.h"
#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <cstddef>

namespace sinew::test_system {

DenseSystem system_of(const MatrixX& A, const MatrixX& B)
{
    DenseSystem system(static_cast<int>(A.rows()), static_cast<int>(B.cols()));
    for (int i = 0; i < system.size(); ++i) {
        Eigen::RowVectorXd::Map(system.row(i), A.cols()) = A.row(i);
        Eigen::RowVectorXd::Map(system.right_side(i), B.cols()) = B.row(i);
    }
    return system;
}

MatrixX solved(const MatrixX& A, const MatrixX& B, const Progress& progress = {})
{
    DenseSystem system = system_of(A, B);
    system.solve(progress);
    MatrixX X(B.rows(), B.cols());
    for (int i = 0; i < system.size(); ++i)
        X.row(i) = Eigen::RowVectorXd::Map(system.solution(i), B.cols());
    return X;
}

TEST(DenseSystem, agrees_with_eigen_at_sizes_around_its_blocks)
{
    MatrixX needs_pivots(3, 3);
    needs_pivots << 0, 1, 2, 1, 0, 3, 4, -3, 0;
    const MatrixX I = MatrixX::Identity(3, 3);
    EXPECT_LT((solved(needs_pivots, I) - dense::solution(needs_pivots, I)).norm(), 1e-14);
    shapes::Random random(1);
    for (int n : {1, 2, 7, 63, 64, 65, 200, 321})
        for (int columns : {1, 5, 8, 17}) {
            const MatrixX A = random.dense(n, n), B = random.dense(n, columns);
            const MatrixX expected = dense::solution(A, B);
            // Random matrices of this size have condition numbers up to 1e5.
            EXPECT_LT((solved(A, B) - expected).norm(), 1e-10 * expected.norm()) << n << " " << columns;
        }
}

TEST(DenseSystem, tells_the_unknown_whose_pivot_is_missing)
{
    shapes::Random random(2);
    MatrixX A = random.dense(100, 100);
    A.col(70) = A.col(20);
    DenseSystem system = system_of(A, random.dense(100, 1));
    system.solve({});
    for (int k = 0; k < 70; ++k)
        EXPECT_GT(system.pivot_sizes()[static_cast<std::size_t>(k)], 1e-6);
    EXPECT_LT(system.pivot_sizes()[70], 1e-12);
}

TEST(DenseSystem, heeds_the_limits_of_threads_and_memory_and_stops_when_it_is_cancelled)
{
    shapes::Random random(3);
    const MatrixX A = random.dense(400, 400), B = random.dense(400, 30), many = solved(A, B);
    int ticks = 0;
    EXPECT_THROW(solved(A, B, Progress([&](double, const char*) { return ++ticks < 2; })), Cancelled);
    const ThreadLimit one(1);
    EXPECT_EQ(solved(A, B), many);
    EXPECT_NO_THROW(DenseSystem(500, 10));
    const MemoryLimit limit(DenseSystem::bytes(500, 10) - 1);
    EXPECT_THROW(DenseSystem(500, 10), OutOfMemory);
}

TEST(DenseKernels, give_the_same_bits_with_wider_instructions)
{
    shapes::Random random(5);
    for (int rows : {1, 4, 7, 8, 13}) {
        const MatrixX a = random.dense(30, rows), b = random.dense(8, 3 * 30); // both read by columns
        const std::vector<int> place{9, 2, 4, 0, 7, 1, 5, 12, 3, 11, 6, 10, 8};
        const MatrixX before = random.dense(24, 13);
        MatrixX plain = before;
        DenseKernels::baseline.add_product(a.data(), 30, 1, rows, 30, b.data(), 3, plain.data(), 24,
                                           place.data());
        for (const DenseKernels* kernels : wide_kernels<DenseKernels>()) {
            MatrixX wide = before;
            kernels->add_product(a.data(), 30, 1, rows, 30, b.data(), 3, wide.data(), 24, place.data());
            EXPECT_EQ(plain, wide);
            wide = before;
            const RowMatrix turned = a; // (inner, rows)
            kernels->add_product(turned.data(), 1, rows, rows, 30, b.data(), 3, wide.data(), 24,
                                 place.data());
            EXPECT_EQ(plain, wide);
        }
        const RowMatrix U = random.dense(rows, 30), right = random.dense(rows, 24);
        RowMatrix solved = right;
        DenseKernels::baseline.substitute(U.data(), 30, rows, solved.data(), 24, 3);
        const MatrixX upper = U.leftCols(rows).triangularView<Eigen::Upper>();
        EXPECT_LT((dense::product(upper.transpose(), solved) - right).norm(), 1e-9 * (1.0 + solved.norm()));
        for (const DenseKernels* kernels : wide_kernels<DenseKernels>()) {
            RowMatrix wide = right;
            kernels->substitute(U.data(), 30, rows, wide.data(), 24, 3);
            EXPECT_EQ(solved, wide);
        }
    }
}

} // namespace sinew::test_system
