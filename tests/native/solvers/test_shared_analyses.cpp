// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/shared_analyses.h"

#include "native/solvers/engines/cholmod_factor.h"
#include "tests/native/dense.h"
#include "tests/native/solvers/matrices.h"

namespace sinew::test_shared_analyses {

std::shared_ptr<const Analysis> kept(const SparseMatrix& A)
{
    return SharedAnalyses::find(
        {digest(A), static_cast<int>(A.cols()), FactorBackend::automatic, Ordering::automatic});
}

TEST(SharedAnalyses, serve_the_factors_of_one_pattern_while_they_live_and_change_no_bit)
{
    if (!have_cholmod())
        GTEST_SKIP() << "this build has no CHOLMOD";
    const SparseMatrix A = matrices::shuffled_grid(20),
                       fourfold = 4 * A; // whose factor has twice the numbers
    const MatrixX b = MatrixX::Ones(A.cols(), 2);
    SpdFactor alone, second;
    alone.factorize(fourfold);
    EXPECT_EQ(kept(A), nullptr);
    {
        const SharedAnalyses shared;
        {
            SpdFactor first;
            first.factorize(A);
            EXPECT_NE(kept(A), nullptr);
            second.factorize(fourfold);
            EXPECT_EQ(first.solve(b), 4 * second.solve(b));
        }
        const SharedAnalyses inner; // which knows nothing yet
        EXPECT_EQ(kept(A), nullptr);
    }
    EXPECT_EQ(kept(A), nullptr);
    EXPECT_EQ(second.solve(b), alone.solve(b));
    EXPECT_EQ(second.analyses(), 1);
    second.factorize(A);
    EXPECT_LT((second.solve(b) - dense::solution(A, b)).cwiseAbs().maxCoeff(), 1e-10);
}

} // namespace sinew::test_shared_analyses
