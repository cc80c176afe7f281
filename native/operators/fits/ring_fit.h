// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// A vertex and its neighbours, seen from their mean.
struct Ring
{
    Vector3 mean;
    /// The pseudo-inverse of sum (|r|^2 1 - r r^T), r = point - mean. Turns about the line of a ring whose
    /// points lie on one have no effect on it, and are zero.
    Matrix3 inverse;
    double inverse_square; ///< 1 / sum |r|^2; 0 where all points are one
};

/// \param L  its off-diagonal entries in the column of a vertex are its neighbours.
/// \param y  (n, 3)
Ring ring_at(const SparseMatrix& L, const PointsView& y, int vertex);

/// The map x -> (1 + scale) x + turn x x, a similarity up to second order in `turn`.
struct LinearSimilarity
{
    double scale = 0.0;
    Vector3 turn = Vector3::Zero();

    double factor() const { return 1.0 + scale; }
    Vector3 operator()(const Vector3& v) const;
    /// The rotation that is closest to it: about `turn`, by atan2(|turn|, 1 + scale).
    Vector3 rotated(const Vector3& v) const;
};

/// The map that fits best to the displacements of a ring, by least squares over its points.
///
/// O. Sorkine et al. "Laplacian Surface Editing." SGP 2004, section 4.
///
///     scale = sum r.d / sum |r|^2,    turn = K^+ sum r x d
///
/// It is linear in the displacements. As the r of a ring sum to zero, translations do not enter.
/// \param y, ring         of ring_at().
/// \param displacements   (n, 3), row-major.
LinearSimilarity fit_ring(const SparseMatrix& L, const PointsView& y, const Ring& ring,
                          const double* displacements, int vertex);

} // namespace sinew
