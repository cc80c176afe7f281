// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// Rows of weights of control points, one row after the other.
using WeightRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// The motions c of control points from point constraints B c = d, in the least-squares sense.
///
/// With weights W of the constraints, whose sum is taken as 1, and t = 1^T W d, the weighted mean,
///
///     sum_i W_i |(B c - d)_i|^2 + s (c - t)^T P (c - t)
///
/// is least. Where that leaves c open, |c - t| is least: with s = 0 and more unknowns than constraints, this
/// is the least norm, and the constraints are met. If the rows of B sum to 1, equal d give equal c.
///
/// With s = 0, directions of c that B scales by less than 1e-6 of its largest singular value count as open.
///
///   call         cost
///   constructor  O(c w^2 + k^3) for c rows of w weights and k control points, k^3 25 times as dear if s = 0
///   solve()      O(c w + k^2) per column
class ControlFit
{
public:
    /// \param B          (c, k) the weights of control points at each constraint.
    /// \param weights    (c) W, not negative, at least one positive.
    /// \param penalty    (k, k) P, symmetric positive semi-definite, with P 1 = 0.
    /// \param smoothing  s >= 0
    /// \throw OutOfMemory  k^2 numbers are more than limit_memory() allows.
    ControlFit(const WeightRows& B, const VectorX& weights, const MatrixX& penalty, double smoothing);

    /// (k, m) c for m columns.
    /// \param wanted  (c, m) d
    RowMatrix solve(const RowMatrix& wanted) const;

    const WeightRows& rows() const { return B_; }
    const VectorX& weights() const { return weights_; } ///< W, whose sum is 1

private:
    WeightRows B_;
    VectorX weights_;
    MatrixX inverse_; ///< of the normal matrix
};

} // namespace sinew
