// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/principal_block.h"

#include "tests/native/solvers/matrices.h"

namespace sinew::test_principal_block {

TEST(PrincipalBlock, is_the_dense_block_with_rows_of_the_identity_and_has_the_digest_of_its_copy)
{
    const SparseMatrix A = matrices::shuffled_grid(5);
    const std::vector<int> unknowns{0, 3, 4, 7, 11, 12, 20, 24};
    std::vector<bool> free(25, true);
    const std::uint64_t all = PrincipalBlock(A, unknowns, free).digest();
    EXPECT_EQ(all, digest(PrincipalBlock(A, unknowns, free).copy()));
    EXPECT_NE(all, PrincipalBlock(A, shapes::numbers(0, 8), free).digest());
    free[4] = free[20] = free[6] = false;
    MatrixX expected(8, 8), visited = MatrixX::Zero(8, 8);
    for (int r = 0; r < 8; ++r)
        for (int c = 0; c < 8; ++c)
            expected(r, c) =
                free[unknowns[r]] && free[unknowns[c]] ? A.coeff(unknowns[r], unknowns[c]) : r == c;

    const PrincipalBlock block(A, unknowns, free);
    EXPECT_EQ(MatrixX(block.copy()), expected);
    EXPECT_EQ(block.diagonal(), expected.diagonal());
    for (int c = 0; c < 8; ++c)
        block.column(c, [&](int r, double value) { visited(r, c) = value; });
    EXPECT_EQ(visited, expected);
    EXPECT_EQ(block.digest(), all) << "whatever is free";
    EXPECT_EQ(digest(block.copy()), all);
}

} // namespace sinew::test_principal_block
