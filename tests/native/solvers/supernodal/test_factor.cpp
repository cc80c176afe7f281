// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/factor.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/spd_factor.h"
#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/solvers/matrices.h"

namespace sinew::test_factor {

/// Large enough for several subtrees, and for supernodes of several panels.
SparseMatrix large()
{
    const SparseMatrix L = matrices::shuffled_grid(110, 0.1);
    return L * L;
}

SpdFactor supernodal() { return SpdFactor({.backend = FactorBackend::supernodal}); }

/// The same pattern with other values in the columns and rows of `unknowns`, still positive definite.
SparseMatrix painted(SparseMatrix A, const std::vector<int>& unknowns)
{
    VectorX scale = VectorX::Ones(A.cols());
    for (int u : unknowns)
        scale[u] = 1.5;
    return scale.asDiagonal() * A * scale.asDiagonal();
}

/// All of a matrix.
struct Whole
{
    explicit Whole(const SparseMatrix& matrix)
        : matrix(matrix), unknowns(shapes::numbers(0, static_cast<int>(matrix.cols()))),
          free(matrix.cols(), true)
    {
    }
    operator PrincipalBlock() const { return {matrix, unknowns, free}; }

    SparseMatrix matrix;
    std::vector<int> unknowns;
    std::vector<bool> free;
};

class SupernodalFactorTest : public testing::Test
{
protected:
    void SetUp() override
    {
        if (!have_cholmod())
            GTEST_SKIP() << "this build has no supernodal factor";
    }
    void TearDown() override { limit_threads(0); }
};

TEST_F(SupernodalFactorTest, solves_as_another_library_does_by_rows_and_columns_and_on_any_number_of_threads)
{
    const SparseMatrix A = large();
    const MatrixX b = MatrixX::Random(A.cols(), 20), expected = dense::solution(A, b);
    MatrixX first;
    for (int threads : {0, 1, 2, 3}) {
        limit_threads(threads);
        SpdFactor factor = supernodal();
        factor.factorize(A);
        EXPECT_GT(factor.nonzeros(), 400'000); // below, a solve would not run in parallel
        const MatrixX x = factor.solve(b);
        if (threads == 0)
            first = x;
        EXPECT_EQ(x, first) << threads;
        limit_threads(0);
        EXPECT_EQ(factor.solve(b), first) << threads;
        EXPECT_LT((x - expected).norm(), 1e-10 * expected.norm()); // condition 6e3
        for (int columns : {1, 3, 7, 20}) {
            RowMatrix rows = b.leftCols(columns);
            factor.solve_rows(rows); // blocked kernels round in another order
            EXPECT_LT((rows - x.leftCols(columns)).norm(), 1e-12 * x.leftCols(columns).norm());
        }
    }
}

TEST_F(SupernodalFactorTest, updated_has_the_bits_of_a_new_one)
{
    const SparseMatrix A = large();
    const std::vector<int> few{3, 4, 500, 7000};
    const SparseMatrix other = painted(A, few);
    // A column changes wherever a row of these does.
    std::vector<int> changed;
    for (int c = 0; c < A.cols(); ++c)
        if (VectorX(A.col(c)) != VectorX(other.col(c)))
            changed.push_back(c);
    const MatrixX b = MatrixX::Random(A.cols(), 3);
    SpdFactor whole = supernodal(), part = supernodal();
    whole.factorize(other);
    part.factorize(A);
    const MatrixX before = part.solve(b);
    ASSERT_TRUE(part.update(Whole(other), changed));
    EXPECT_EQ(part.solve(b), whole.solve(b));
    EXPECT_GT(part.share(), 0.0);
    EXPECT_LT(part.share(), 0.8);
    EXPECT_EQ(part.analyses(), 1);
    EXPECT_EQ(part.factorizations(), 2);
    ASSERT_TRUE(part.update(Whole(A), changed));
    EXPECT_EQ(part.solve(b), before);
}

TEST_F(SupernodalFactorTest, is_not_updated_where_most_of_it_changed_or_the_pattern_is_another)
{
    const SparseMatrix A = large();
    const std::vector<int> all = shapes::numbers(0, static_cast<int>(A.cols()));
    SpdFactor factor = supernodal();
    EXPECT_FALSE(factor.update(Whole(A), {}));
    factor.factorize(A);
    EXPECT_FALSE(factor.update(Whole(2 * A), all));
    EXPECT_FALSE(factor.update(Whole(matrices::shuffled_grid(110, 0.1)), {0}));
    const MatrixX b = MatrixX::Random(A.cols(), 1);
    SpdFactor fresh = supernodal();
    fresh.factorize(A);
    EXPECT_EQ(factor.solve(b), fresh.solve(b));
}

TEST_F(SupernodalFactorTest, that_breaks_down_names_the_unknown_and_can_be_factorised_again)
{
    const SparseMatrix A = large();
    SparseMatrix bad = A;
    bad.coeffRef(5000, 5000) = -1;
    SpdFactor factor = supernodal();
    factor.factorize(A);
    const auto update = [&] { factor.update(Whole(bad), {5000}); };
    EXPECT_EQ(refusal<FactorizationFailed>(update).elements().size(), 1u);
    EXPECT_THROW(factor.solve(MatrixX::Ones(A.cols(), 1)), FactorizationFailed);
    factor.factorize(A);
    const MatrixX ones = MatrixX::Ones(A.cols(), 1);
    EXPECT_LT((A * factor.solve(ones) - ones).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_EQ(factor.analyses(), 1);
}

} // namespace sinew::test_factor
