// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/control_fit.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/memory.h"

namespace sinew {

namespace {

constexpr double least_singular = 1e-6; ///< as a share of the largest
/// Of the squares of all motions, beside a penalty that leaves some of them open.
constexpr double least_norm = 1e-10;

} // namespace

ControlFit::ControlFit(const WeightRows& B, const VectorX& weights, const MatrixX& penalty, double smoothing)
    : B_(B), weights_(weights / weights.sum())
{
    const Eigen::Index k = B_.cols();
    require_memory(2 * static_cast<std::int64_t>(sizeof(double)) * k * k, "the fit of the control grid");
    MatrixX normal = MatrixX::Zero(k, k);
    for (Eigen::Index row = 0; row < B_.rows(); ++row)
        for (WeightRows::InnerIterator a(B_, row); a; ++a)
            for (WeightRows::InnerIterator b(B_, row); b; ++b)
                normal(a.col(), b.col()) += weights_[row] * a.value() * b.value();
    if (smoothing > 0) {
        normal += smoothing * penalty;
        normal.diagonal().array() += least_norm;
        CholeskyFactor factor;
        if (!factor.factorize(normal))
            throw FactorizationFailed("the fit of the control grid has no unique solution");
        inverse_ = factor.solve(MatrixX(MatrixX::Identity(k, k)));
        return;
    }
    const auto [values, vectors] = eigenvectors(normal);
    const double least = least_singular * least_singular * values[k - 1];
    const VectorX inverses = (values.array() > least).select(values.cwiseInverse(), 0.0);
    inverse_ = product(vectors * inverses.asDiagonal(), vectors.transpose());
}

RowMatrix ControlFit::solve(const RowMatrix& wanted) const
{
    const Eigen::RowVectorXd mean = weights_.transpose() * wanted;
    const RowMatrix around = weights_.asDiagonal() * (wanted.rowwise() - mean);
    RowMatrix c = inverse_ * (B_.transpose() * around);
    c.rowwise() += mean;
    return c;
}

} // namespace sinew
