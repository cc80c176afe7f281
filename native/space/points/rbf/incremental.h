// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/space/points/rbf/polynomials.h"
#include "native/space/points/rbf/system.h"

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
/// S. Mueller, R. Schaback. "A Newton basis for kernel spaces." Journal of Approximation Theory 161, 2009.
///
/// Departs from the first paper: the values are met at the centres, where the paper takes least squares over
/// all points. That needs some more centres, and a quarter of the time: the Newton basis of the second paper
/// is the Cholesky factor of psi (see RbfSystem), of which each new centre adds a column. A point that has
/// become a centre has no residual any more, so with all points as centres this is the dense system.
///
/// Of very many points, some are fitted at first, spread evenly in their order; then all are checked, and
/// those that are missed join them.
///
/// Cost: m n^2 - 2/3 n^3 operations for m points and n centres; the dense system takes m^3 / 3.
/// \param points     (m, 3)
/// \param values     (m, k)
/// \param tolerance  > 0, of RbfFit::error.
/// \throw OutOfMemory, Cancelled
RbfFit fit_incrementally(const Points& points, const RowMatrix& values, const RbfBasis& basis,
                         const Polynomials& polynomials, double tolerance, const Progress& progress);

} // namespace sinew
