// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/spd_factor.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "tests/native/dense.h"
#include "tests/native/refusals.h"
#include "tests/native/solvers/matrices.h"
#include "tests/native/threads.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace sinew::test_spd_factor {

namespace {

using Choice = std::tuple<FactorBackend, Ordering>;

std::string name_of(const testing::TestParamInfo<Choice>& info)
{
    static const char* const backends[] = {"automatic", "supernodal", "simplicial", "ldlt"};
    static const char* const orderings[] = {"natural", "cuthill_mckee", "minimum_degree", "dissection"};
    return std::string(backends[static_cast<int>(std::get<0>(info.param))]) + "_" +
           orderings[static_cast<int>(std::get<1>(info.param))];
}

class EveryFactor : public testing::TestWithParam<Choice>
{
protected:
    void SetUp() override
    {
        const bool needs_cholmod = backend() == FactorBackend::supernodal ||
                                   backend() == FactorBackend::simplicial ||
                                   ordering() == Ordering::nested_dissection;
        if (needs_cholmod && !have_cholmod())
            GTEST_SKIP() << "this build has no CHOLMOD";
    }
    static FactorBackend backend() { return std::get<0>(GetParam()); }
    static Ordering ordering() { return std::get<1>(GetParam()); }
    static SpdFactor make() { return SpdFactor({.backend = backend(), .ordering = ordering()}); }
};

/// Largest difference to a dense LU solve, relative to the solution.
double error_of(const SpdFactor& factor, const SparseMatrix& A, const MatrixX& b)
{
    const MatrixX expected = dense::solution(A, b);
    return (factor.solve(b) - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

FactorizationFailed failure(SpdFactor& factor, const SparseMatrix& A)
{
    return refusal<FactorizationFailed>([&] { factor.factorize(A); });
}

} // namespace

// Condition numbers here stay below 1e3, so 1e-12 leaves a digit for 1e3 x epsilon.
constexpr double well_conditioned = 1e-12;

TEST_P(EveryFactor, solves_as_dense_elimination_does)
{
    shapes::Random random(1);
    for (int n : {1, 2, 7, 40, 150}) {
        const SparseMatrix A = matrices::random_spd(n, n);
        SpdFactor factor = make();
        factor.factorize(A);
        EXPECT_EQ(factor.size(), n);
        for (int columns : {1, 3, 12})
            EXPECT_LT(error_of(factor, A, random.dense(n, columns)), well_conditioned) << n;
    }
}

TEST_P(EveryFactor, solves_from_the_lower_triangle_alone)
{
    shapes::Random random(2);
    const SparseMatrix A = matrices::random_spd(60, 5);
    const SparseMatrix lower = A.triangularView<Eigen::Lower>();
    SpdFactor factor = make();
    factor.factorize(lower);
    EXPECT_LT(error_of(factor, A, random.dense(60, 2)), well_conditioned);
}

TEST_P(EveryFactor, keeps_the_symbolic_part_while_the_pattern_stays)
{
    shapes::Random random(3);
    SpdFactor factor = make();
    const SparseMatrix A = matrices::shuffled_grid(9);
    for (int k = 1; k <= 3; ++k) {
        const SparseMatrix scaled = k * A;
        factor.factorize(scaled);
        EXPECT_EQ(factor.analyses(), 1);
        EXPECT_EQ(factor.factorizations(), k);
        EXPECT_LT(error_of(factor, scaled, random.dense(81, 1)), well_conditioned);
    }
    const SparseMatrix other = matrices::random_spd(81, 6);
    factor.factorize(other);
    EXPECT_EQ(factor.analyses(), 2);
    EXPECT_LT(error_of(factor, other, random.dense(81, 1)), well_conditioned);
}

TEST_P(EveryFactor, sees_another_pattern_of_the_same_size)
{
    // Pairs 0-1 and 2-3, then 0-2 and 1-3: two entries a column in both.
    SpdFactor factor = make();
    for (const auto& [a, b, c, d] : {std::array{0, 1, 2, 3}, {0, 2, 1, 3}}) {
        SparseMatrix A = matrices::diagonal({2, 3, 4, 5});
        A.coeffRef(a, b) = A.coeffRef(b, a) = A.coeffRef(c, d) = A.coeffRef(d, c) = 1;
        A.makeCompressed();
        factor.factorize(A);
        EXPECT_LT(error_of(factor, A, MatrixX::Identity(4, 4)), well_conditioned);
    }
    EXPECT_EQ(factor.analyses(), 2);
}

TEST_P(EveryFactor, names_the_unknown_where_a_matrix_breaks_down)
{
    SpdFactor factor = make();
    expect_elements(failure(factor, matrices::diagonal({1, 2, 3, -1, 4})), Error::Element::vertex, {3});
    expect_elements(failure(factor, matrices::diagonal({1, 2, 0, 3})), Error::Element::vertex,
                    {2}); // not held
}

TEST_P(EveryFactor, refuses_what_has_no_factor_and_factorises_again)
{
    SpdFactor factor = make();
    failure(factor, matrices::shuffled_grid(8, 0.0)); // a Laplacian without constraints
    failure(factor, matrices::diagonal({1, std::numeric_limits<double>::quiet_NaN(), 1}));
    failure(factor, matrices::diagonal({1, -1, 1}));
    EXPECT_THROW(factor.solve(MatrixX::Ones(3, 1)), FactorizationFailed);
    const SparseMatrix good = matrices::diagonal({1, 2, 4});
    factor.factorize(good);
    EXPECT_LT(error_of(factor, good, MatrixX::Ones(3, 1)), well_conditioned);
}

TEST_P(EveryFactor, tells_its_memory_before_it_takes_it)
{
    const SparseMatrix A = matrices::shuffled_grid(30);
    SpdFactor factor = make();
    factor.factorize(A);
    // Eight bytes an entry, four more for its row where no block shares them, and a few integers
    // an unknown.
    EXPECT_GE(factor.bytes(), 8 * factor.nonzeros());
    EXPECT_LE(factor.bytes(), 12 * factor.nonzeros() + 100 * factor.size());
}

TEST_P(EveryFactor, above_the_memory_limit_is_refused_and_the_old_one_stays)
{
    const SparseMatrix small = matrices::shuffled_grid(5), large = matrices::shuffled_grid(40);
    const MatrixX b = MatrixX::Ones(25, 1);
    SpdFactor factor = make();
    factor.factorize(small);
    const MatrixX before = factor.solve(b);
    std::string text;
    {
        const MemoryLimit limit(100'000);
        text = failure(factor, large).what();
    }
    EXPECT_NE(text.find("the memory limit is 0.1 MB"), std::string::npos) << text;
    EXPECT_EQ(factor.size(), 25);
    EXPECT_EQ(factor.factorizations(), 1);
    EXPECT_EQ(factor.solve(b), before);
    factor.factorize(large);
    const MatrixX ones = MatrixX::Ones(1600, 1);
    EXPECT_LT((large * factor.solve(ones) - ones).cwiseAbs().maxCoeff(), 1e-10); // condition 1e3
    EXPECT_GT(factor.bytes(), 100'000);
}

TEST_P(EveryFactor, does_not_mind_the_scale)
{
    shapes::Random random(4);
    for (double scale : {1e-60, 1e60}) {
        const SparseMatrix A = scale * matrices::random_spd(50, 8);
        SpdFactor factor = make();
        factor.factorize(A);
        EXPECT_LT(error_of(factor, A, random.dense(50, 2)), well_conditioned);
    }
}

TEST_P(EveryFactor, solves_from_several_threads_give_the_same_bits)
{
    shapes::Random random(5);
    const SparseMatrix A = matrices::shuffled_grid(25);
    SpdFactor factor = make();
    factor.factorize(A);
    const MatrixX b = random.dense(static_cast<int>(A.rows()), 3);
    const MatrixX alone = factor.solve(b);
    expect_in_threads(4, 20, [&] { return factor.solve(b); }, alone);
}

INSTANTIATE_TEST_SUITE_P(SpdFactor, EveryFactor,
                         testing::Combine(testing::Values(FactorBackend::automatic, FactorBackend::supernodal,
                                                          FactorBackend::simplicial, FactorBackend::ldlt),
                                          testing::Values(Ordering::natural, Ordering::reverse_cuthill_mckee,
                                                          Ordering::minimum_degree,
                                                          Ordering::nested_dissection)),
                         name_of);

TEST(SpdFactor, of_no_unknowns_solves_nothing)
{
    SpdFactor factor;
    factor.factorize(SparseMatrix(0, 0));
    EXPECT_EQ(factor.solve(MatrixX(0, 3)).cols(), 3);
    EXPECT_EQ(factor.nonzeros(), 0);
}

TEST(SpdFactor, moves_with_its_factor)
{
    SpdFactor first;
    const SparseMatrix A = matrices::random_spd(20, 9);
    first.factorize(A);
    const SpdFactor second = std::move(first);
    EXPECT_LT(error_of(second, A, MatrixX::Ones(20, 1)), well_conditioned);
}

} // namespace sinew::test_spd_factor
