// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/turned_poses.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/operators/fits/rotation_fit.h"

#include <algorithm>
#include <limits>
#include <string>

namespace sinew {

namespace {

constexpr double little =
    1e-3; ///< how much the turn of all points counts beside that of the edges at a point
/// How much no turn at all counts, so that points on a line turn as little as they can.
constexpr double least = 1e-9;

void check(PointsView rest, PointsView posed, const std::vector<std::array<int, 2>>& edges)
{
    if (posed.rows() != rest.rows())
        throw InvalidConstraint("posed: " + std::to_string(posed.rows()) + " points given for " +
                                std::to_string(rest.rows()));
    if (!all_finite(rest) || !all_finite(posed))
        throw InvalidConstraint("a point is not finite");
    for (const auto& edge : edges)
        for (const int point : edge)
            if (point < 0 || point >= rest.rows())
                throw InvalidConstraint("edges: there is no point " + std::to_string(point) + " among " +
                                        std::to_string(rest.rows()));
}

/// The turn of all points together.
Matrix3 common_turn(PointsView rest, PointsView posed)
{
    const Points local = rest.rowwise() - rest.colwise().mean();
    const Points moved = posed.rowwise() - posed.colwise().mean();
    const double size = std::max(local.squaredNorm(), std::numeric_limits<double>::min());
    return fit_rotation_svd(moved.transpose() * local / size + least * Matrix3::Identity());
}

} // namespace

Poses turned_poses(PointsView rest, PointsView posed, const std::vector<std::array<int, 2>>& edges)
{
    check(rest, posed, edges);
    if (rest.rows() == 0)
        return {};
    std::vector<Matrix3> fits(static_cast<std::size_t>(rest.rows()), little * common_turn(rest, posed));
    for (const auto& [a, b] : edges) {
        const Eigen::RowVector3d before = rest.row(b) - rest.row(a), after = posed.row(b) - posed.row(a);
        const double square = before.squaredNorm();
        if (square > 0.0)
            for (const int end : {a, b})
                fits[end] += after.transpose() * before / square;
    }
    Poses poses(fits.size());
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        poses[i].leftCols<3>() = fit_rotation_svd(fits[i]);
        poses[i].col(3) = posed.row(i).transpose() - poses[i].leftCols<3>() * rest.row(i).transpose();
    }
    return poses;
}

} // namespace sinew
