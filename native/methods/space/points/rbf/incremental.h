// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/methods/space/points/rbf/polynomials.h"
#include "native/methods/space/points/rbf/system.h"

namespace sinew {

/// What an incremental fit found.
struct RbfFit
{
    Points centres;
    RbfCoefficients coefficients;
    double error = 0.0; ///< the largest residual of a point, as a sum of magnitudes over all columns
};

/// Fits radial basis functions at few of many points:
///
/// M. Botsch, L. Kobbelt. "Real-Time Shape Editing using Radial Basis Functions." Eurographics 2005,
/// section 4: centres are added where the residuals are largest, weighted by their distance from other
/// centres, until all points are met.
/// F. Schaefer, M. Katzfuss, H. Owhadi. "Sparse Cholesky factorization by Kullback-Leibler minimization."
/// SIAM Journal on Scientific Computing 43, 2021.
///
/// Departs from the first paper: the values are met at the centres, where the paper takes least squares over
/// all points. Centres come in blocks, of half as many as there are. Conjugate gradients find their weights,
/// from the former ones on. The preconditioner is the second paper's: each centre knows the nearest of those
/// before it, and adds a column that stays as it is. psi (see RbfSystem) needs some ten products then,
/// and is never stored.
///
/// Of very many points, some are fitted at first, spread evenly in their order; then all are checked, and
/// those that are missed join them.
///
/// Cost: some 30 evaluations of n^2 values of phi, and 10 of m n, for m points and n centres; the dense
/// system takes m^3 / 3 operations.
/// \param points     (m, 3)
/// \param values     (m, k)
/// \param tolerance  > 0, of RbfFit::error.
/// \throw Cancelled
RbfFit fit_incrementally(const Points& points, const RowMatrix& values, const RbfBasis& basis,
                         const Polynomials& polynomials, double tolerance, const Progress& progress);

} // namespace sinew
