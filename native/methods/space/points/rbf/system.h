// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/methods/space/points/rbf/kernels.h"
#include "native/methods/space/points/rbf/polynomials.h"
#include "native/solvers/dense/cholesky.h"
#include "native/solvers/spd_factor.h"

#include <Eigen/Cholesky>

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// A radial basis function and its scale: phi(|x - c| scale).
struct RbfBasis
{
    RbfFunction function = RbfFunction::triharmonic;
    double scale = 1.0;
};

/// phi of points (n, 3) at centres (c, 3), as (n, c).
RowMatrix rbf_values(const RbfBasis& basis, const Points& points, const Points& centres);

/// rbf_values() times weights (c, columns), as (n, columns), without all values at once.
RowMatrix rbf_sums(const RbfBasis& basis, const Points& points, const Points& centres,
                   const RowMatrix& weights);

/// f(x) = sum_j w_j phi(|x - c_j|) + sum_k a_k p_k(x)
struct RbfCoefficients
{
    RowMatrix weights;    ///< (c, columns) w
    RowMatrix polynomial; ///< (count, columns) a
};

/// The interpolants f(c_i) = f_i with sum_j w_j p(c_j) = 0 for all p, see Rbf.
///
/// phi is positive definite on the weights that meet this condition. With the base points z and their
/// Lagrange polynomials L, a global phi becomes
///
///     psi(x, y) = phi(x, y) - L(x) phi(z, y) - phi(x, z) L(y)^T + L(x) phi(z, z) L(y)^T
///
/// which is positive definite at the other points, and gets a dense Cholesky factor. A compact phi is
/// factorised as a sparse matrix, and the condition is a Schur complement.
class RbfSystem
{
public:
    RbfSystem() = default;
    /// \param centres  (c, 3) no two at one place.
    /// \throw FactorizationFailed  phi is singular up to rounding, also with a diagonal of 1e-7 of its
    /// values.
    /// \throw OutOfMemory, Cancelled
    RbfSystem(const Points& centres, const RbfBasis& basis, const Polynomials& polynomials,
              const Progress& progress);

    /// \param values  (c, k)
    RbfCoefficients solve(const RowMatrix& values) const;

    /// What was added to the diagonal, as a share of the values of phi; 0 unless centres nearly coincide.
    double softness() const { return softness_; }
    std::int64_t bytes() const;

private:
    void factorize_dense(const Points& centres, const RbfBasis& basis, const RowMatrix& P,
                         const Progress& progress);
    void fill(const Points& others, const RbfBasis& basis, const MatrixX& lagrange, const MatrixX& half);
    void factorize_sparse(const Points& centres, const RbfBasis& basis, const RowMatrix& P,
                          const Progress& progress);

    int count_ = 0, polynomials_ = 0;
    double softness_ = 0.0;
    LagrangeBase base_;
    std::vector<int> others_; ///< the centres that are no base points
    MatrixX at_base_;         ///< (c, count) phi at the base points
    DenseCholesky dense_;     ///< of psi at the others
    std::unique_ptr<SpdFactor> sparse_;
    RowMatrix P_, solved_P_;                ///< of the sparse system: P, and Phi^-1 P
    std::unique_ptr<Eigen::LDLT<MatrixX>> schur_; ///< P^T Phi^-1 P, which may be singular up to rounding
};

} // namespace sinew
