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

/// Fits radial basis functions at few of many points, by incremental least squares:
///
/// M. Botsch, L. Kobbelt. "Real-Time Shape Editing using Radial Basis Functions." Eurographics 2005,
/// section 4.
///
/// The values at all points are approximated, with centres at the points of the largest residuals, weighted
/// by their distance from other centres. A QR factorisation gains columns until the error is met: each block
/// of columns is made orthogonal to those before it, twice. A column is phi at a centre less its interpolant
/// by polynomials at `count` base points, so the weights are orthogonal to the polynomials by themselves, and
/// with all points as centres the fit is the interpolant.
///
/// Cost: 4 m n^2 operations for m points and n centres; the dense system takes m^3 / 3.
/// \param points     (m, 3)
/// \param values     (m, k)
/// \param tolerance  > 0, of RbfFit::error.
/// \param most       centres.
/// \throw OutOfMemory, Cancelled
RbfFit fit_incrementally(const Points& points, const RowMatrix& values, const RbfBasis& basis,
                         const Polynomials& polynomials, double tolerance, int most,
                         const Progress& progress);

} // namespace sinew
