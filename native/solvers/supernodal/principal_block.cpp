// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/principal_block.h"

#include "native/core/parallel.h"

namespace sinew {

namespace {

/// A digest of a pattern of n columns, as a sum of hashed indices. visit(c, entry) calls entry(row) for each
/// entry of column c.
template <class Visit>
std::uint64_t digest_of(int columns, Visit&& visit)
{
    const auto mix = [](std::uint64_t x) {
        x = (x ^ (x >> 31)) * 0x9fb21c651e98df25ULL;
        x = (x ^ (x >> 29)) * 0xd6e8feb86659fd93ULL;
        return x ^ (x >> 32);
    };
    constexpr int grain = 8192;
    std::vector<std::uint64_t> sums((columns + grain - 1) / grain, 0);
    parallel_chunks(columns, grain, [&](int begin, int end) {
        std::uint64_t sum = 0;
        for (int c = begin; c < end; ++c)
            visit(c, [&](int row) {
                sum += 1 + mix((static_cast<std::uint64_t>(c) << 32) + static_cast<std::uint32_t>(row));
            });
        sums[begin / grain] = sum;
    });
    std::uint64_t sum = 0;
    for (const std::uint64_t part : sums)
        sum += part;
    return sum;
}

} // namespace

std::uint64_t digest(const SparseMatrix& matrix)
{
    return digest_of(static_cast<int>(matrix.cols()), [&](int c, const auto& entry) {
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it)
            entry(static_cast<int>(it.row()));
    });
}

PrincipalBlock::PrincipalBlock(const SparseMatrix& matrix, const std::vector<int>& unknowns,
                               const std::vector<bool>& free)
    : matrix_(matrix), unknowns_(unknowns), free_(free), place_(matrix.cols(), -1)
{
    for (int u = 0; u < size(); ++u)
        place_[unknowns[u]] = u;
}

std::uint64_t PrincipalBlock::digest() const
{
    return digest_of(size(), [&](int u, const auto& entry) {
        for (SparseMatrix::InnerIterator it(matrix_, unknowns_[u]); it; ++it)
            if (place_[it.row()] >= 0)
                entry(place_[it.row()]);
    });
}

SparseMatrix PrincipalBlock::copy() const
{
    SparseMatrix block(size(), size());
    int* offsets = block.outerIndexPtr();
    parallel_for(size(), [&](int u) {
        int count = 0;
        for (SparseMatrix::InnerIterator it(matrix_, unknowns_[u]); it; ++it)
            count += place_[it.row()] >= 0;
        offsets[u + 1] = count;
    });
    for (int u = 0; u < size(); ++u)
        offsets[u + 1] += offsets[u];
    block.resizeNonZeros(offsets[size()]);
    parallel_for(size(), [&](int u) {
        const int column = unknowns_[u];
        int at = offsets[u];
        for (SparseMatrix::InnerIterator it(matrix_, column); it; ++it) {
            const int row = static_cast<int>(it.row());
            if (place_[row] < 0)
                continue;
            const bool both = free_[row] && free_[column];
            block.innerIndexPtr()[at] = place_[row];
            block.valuePtr()[at++] = both ? it.value() : row == column ? 1.0 : 0.0;
        }
    });
    return block;
}

VectorX PrincipalBlock::diagonal() const
{
    VectorX diagonal(size());
    parallel_for(size(), [&](int u) {
        const int row = unknowns_[u];
        diagonal[u] = free_[row] ? matrix_.coeff(row, row) : 1.0;
    });
    return diagonal;
}

} // namespace sinew
