// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/solvers/engines/factor_engine.h"
#include "native/solvers/orderings.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// automatic: CHOLMOD supernodal for second-ring matrices (12 and more entries a row) and
/// for more than 60,000 unknowns, simplicial below, where
/// its solves are 1.4-2.5 times faster; Eigen's LDL^T in a build without CHOLMOD.
enum class FactorBackend { automatic, supernodal, simplicial, ldlt };

struct FactorOptions
{
    FactorBackend backend = FactorBackend::automatic;
    Ordering ordering = Ordering::minimum_degree;
};

/// Sparse Cholesky factor of a symmetric positive definite matrix.
///
///   call          repeat it when ...      cost
///   factorize()   the values changed      numeric; symbolic too when the pattern changed
///   update()      some columns changed    numeric, of what these columns reach
///   solve()       the right side changed  two triangular solves a column
class SpdFactor
{
public:
    explicit SpdFactor(const FactorOptions& options = {});
    ~SpdFactor();
    SpdFactor(SpdFactor&&) noexcept;
    SpdFactor& operator=(SpdFactor&&) noexcept;

    /// \param matrix  (n, n) symmetric, both triangles or the lower one stored.
    /// \throw FactorizationFailed  not positive definite or nearly singular; names an unknown as
    ///   element `vertex`.
    /// \throw OutOfMemory  above limit_memory(), told before the factor is computed and with what
    ///   stood here untouched; or above what the machine has.
    void factorize(const SparseMatrix& matrix);

    /// The same for some rows and columns of a matrix.
    void factorize(const PrincipalBlock& block);

    /// The same for a block that differs in `changed` columns and rows alone. False, and nothing is done,
    /// where that is not faster than factorize(): another pattern, another engine, too many columns reached.
    /// The factor is that of factorize() to the last bit.
    /// \throw FactorizationFailed, OutOfMemory  as factorize().
    bool update(const PrincipalBlock& block, const std::vector<int>& changed);

    /// \param rhs  (n, k), any number of columns; x, y and z together cost 1.3-1.7 times one.
    /// \throw FactorizationFailed  the last matrix was refused.
    MatrixX solve(const MatrixX& rhs) const;
    /// The same by rows, in place: right-hand sides in, solutions out.
    void solve_rows(RowMatrix& x) const;

    /// The factor itself where it is supernodal; else none.
    std::optional<SupernodalFactor> supernodal() const
    {
        return stands_ && engine_ ? engine_->supernodal() : std::nullopt;
    }

    int size() const { return size_; }
    std::int64_t nonzeros() const;
    std::int64_t bytes() const;                            ///< memory of the factor
    int factorizations() const { return factorizations_; } ///< numeric ones, so far
    int analyses() const { return analyses_; }             ///< symbolic ones, so far
    double share() const { return share_; } ///< of a whole numeric factorisation that the last one did

private:
    void analyze(const SparseMatrix& matrix, std::uint64_t pattern);
    void forget();
    template <class Matrix>
    int compute(const Matrix& matrix);
    void check(const VectorX& diagonal, int broken);
    void require_factor(Eigen::Index rows) const;

    FactorOptions options_;
    std::unique_ptr<FactorEngine> engine_;
    std::uint64_t pattern_ = 0; ///< the analysed one's digest
    int size_ = 0;
    bool stands_ = false; ///< the last factorisation succeeded
    int factorizations_ = 0;
    int analyses_ = 0;
    double share_ = 0;
};

} // namespace sinew
