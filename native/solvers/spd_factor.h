// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"
#include "native/solvers/engines/factor_engine.h"
#include "native/solvers/orderings.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// The libraries that factorise.
enum class FactorBackend {
    automatic,  ///< the fastest of these for the matrix, see below
    supernodal, ///< CHOLMOD with one dense block per supernode
    simplicial, ///< CHOLMOD with one column at a time
    ldlt        ///< Eigen's LDL^T
};
constexpr auto choices(FactorBackend)
{
    return std::array{Choice{"automatic", FactorBackend::automatic},
                      Choice{"supernodal", FactorBackend::supernodal},
                      Choice{"simplicial", FactorBackend::simplicial}, Choice{"ldlt", FactorBackend::ldlt}};
}
// automatic is supernodal, whose solves are our own: three columns of a Laplacian of 10,000 unknowns take as
// long as with simplicial, and those of 50,000 a third as long, as does its factor; and ldlt in a build
// without CHOLMOD.

struct FactorOptions
{
    FactorBackend backend = FactorBackend::automatic;
    Ordering ordering = Ordering::automatic;
};

/// Sparse Cholesky factor of a symmetric positive definite matrix.
///
///   call          repeat it when ...      cost
///   factorize()   the values changed      a numeric factorisation; a symbolic one if the pattern changed
///   update()      some columns changed    a numeric factorisation of what depends on these columns
///   solve()       the right side changed  two triangular solves per column
class SpdFactor
{
public:
    explicit SpdFactor(const FactorOptions& options = {});
    ~SpdFactor();
    SpdFactor(SpdFactor&&) noexcept;
    SpdFactor& operator=(SpdFactor&&) noexcept;

    /// \param matrix  (n, n) symmetric, both triangles or the lower one stored.
    /// \throw FactorizationFailed  the matrix is not positive definite or nearly singular; the element of the
    ///   error, a vertex, is the unknown at which this showed.
    /// \throw OutOfMemory  the factor would need more than limit_memory() allows, in which case the former
    ///   factor is kept; or it needs more than the machine has.
    void factorize(const SparseMatrix& matrix);

    /// The same for some rows and columns of a matrix.
    void factorize(const PrincipalBlock& block);

    /// The same for a block of which only the `changed` columns and rows differ from the last one. The factor
    /// is that of factorize() to the last bit.
    /// \return false, and nothing is done, where this is not faster than factorize(): the pattern is another
    ///   one, the engine cannot update, or too much depends on the changed columns.
    /// \throw FactorizationFailed, OutOfMemory  as factorize().
    bool update(const PrincipalBlock& block, const std::vector<int>& changed);

    /// \param rhs  (n, k) any number of columns; three together cost 1.3 to 1.7 times as much as one.
    /// \throw FactorizationFailed  the last matrix was refused.
    MatrixX solve(const MatrixX& rhs) const;
    /// The same by rows and in place: x has the right-hand sides at first and the solutions afterwards.
    void solve_rows(RowMatrix& x) const;

    /// The factor itself if it is supernodal.
    std::optional<SupernodalFactor> supernodal() const
    {
        return valid_ && engine_ ? engine_->supernodal() : std::nullopt;
    }

    int size() const { return size_; }
    std::int64_t nonzeros() const;
    std::int64_t bytes() const; ///< memory of the factor
    int factorizations() const { return factorizations_; } ///< numeric factorisations so far
    int analyses() const { return analyses_; } ///< symbolic factorisations so far
    /// The work of the last numeric factorisation, as a share of that of a whole one.
    double share() const { return share_; }

private:
    /// \param copy  gives the matrix.
    template <class Copy>
    void analyze(int size, std::uint64_t pattern, const Copy& copy);
    void clear();
    template <class Matrix>
    int compute(const Matrix& matrix);
    void check(const VectorX& diagonal, int broken);
    void require_factor(Eigen::Index rows) const;

    FactorOptions options_;
    std::unique_ptr<FactorEngine> engine_;
    std::uint64_t pattern_ = 0; ///< digest of the pattern that was analysed
    int size_ = 0;
    bool valid_ = false; ///< whether the last factorisation succeeded
    int factorizations_ = 0;
    int analyses_ = 0;
    double share_ = 0;
};

} // namespace sinew
