// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/subdivided_level.h"

#include "native/core/parallel.h"

#include <utility>

namespace sinew {

namespace {

/// Added to the diagonal of P^T P, whose eigenvalues are at least .05 where it is not singular. Each step of
/// the fit leaves this share of the error over the eigenvalue, so two leave 1e-11; and one over it is how
/// much rounding errors grow where P^T P is singular.
constexpr double damping = 1e-7;
constexpr int steps = 2;

} // namespace

SubdividedLevel::SubdividedLevel(UndoneLevel level) : level_(std::move(level)), columns_(level_.rule)
{
    SparseMatrix normal = SparseMatrix(columns_.transpose()) * columns_;
    for (int j = 0; j < coarse_count(); ++j)
        normal.coeffRef(j, j) += damping;
    normal_.factorize(normal);
}

std::int64_t SubdividedLevel::bytes() const
{
    const std::int64_t entry = sizeof(int) + sizeof(double);
    return normal_.bytes() + 2 * entry * level_.rule.nonZeros() +
           static_cast<std::int64_t>(level_.frames.bytes() + level_.made.size() * sizeof(Vector3));
}

void SubdividedLevel::predict(const Points& c, Points& x) const
{
    x.resize(fine_count(), 3);
    parallel_for(fine_count(), [&](int i) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (SparseRows::InnerIterator it(level_.rule, i); it; ++it)
            sum += it.value() * c.row(it.col());
        x.row(i) = sum;
    });
}

void SubdividedLevel::analyse(const PointsView& y, Points& c, std::vector<Vector3>& details,
                              Workspace& work) const
{
    const int coarse = coarse_count(), made = static_cast<int>(level_.made.size());
    c.resize(coarse, 3);
    work.gap.resize(fine_count(), 3);
    work.step.resize(coarse, 3);
    parallel_for(coarse, [&](int j) { c.row(j) = y.row(level_.kept[j]); });
    for (int step = 0; step < steps; ++step) {
        predict(c, work.predicted);
        parallel_for(fine_count(), [&](int i) { work.gap.row(i) = y.row(i) - work.predicted.row(i); });
        parallel_for(coarse, [&](int j) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (SparseMatrix::InnerIterator it(columns_, j); it; ++it)
                sum += it.value() * work.gap.row(it.row());
            work.step.row(j) = sum;
        });
        normal_.solve_rows(work.step);
        parallel_for(coarse, [&](int j) { c.row(j) += work.step.row(j); });
    }
    predict(c, work.predicted);
    details.resize(level_.made.size());
    parallel_for(made, [&](int k) {
        const int v = level_.made[k];
        const Matrix3 frame = level_.frames.at(k, v, work.predicted, Matrix3::Identity());
        details[k] = frame.transpose() * (y.row(v) - work.predicted.row(v)).transpose();
    });
}

void SubdividedLevel::synthesise(const Points& c, const std::vector<Vector3>& details,
                                 const std::function<Matrix3(int vertex)>& fallback, Points& x,
                                 Workspace& work) const
{
    predict(c, work.predicted);
    x = work.predicted;
    parallel_for(static_cast<int>(level_.made.size()), [&](int k) {
        const int v = level_.made[k];
        const Matrix3 frame = level_.frames.at(k, v, work.predicted, fallback(v));
        x.row(v) += (frame * details[k]).transpose();
    });
}

} // namespace sinew
