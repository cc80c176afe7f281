// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf/near_centres.h"

#include <numeric>

namespace sinew {

namespace {

constexpr double cells_per_centre = 4.0; ///< at most

} // namespace

NearCentres::NearCentres(const Points& centres, double reach)
    : reach_(reach), corner_(centres.colwise().minCoeff()), order_(static_cast<std::size_t>(centres.rows())),
      centres_(centres.rows(), 3)
{
    const Vector3 extent = Vector3(centres.colwise().maxCoeff()) - corner_;
    const auto cells_of = [&](double edge) -> Vector3 { return (extent / edge).array().floor() + 1.0; };
    if (std::isfinite(reach)) {
        edge_ = 0.7 * reach; // fastest for 20 to 200 centres within reach
        while (cells_of(edge_).prod() > cells_per_centre * static_cast<double>(centres.rows()) + 8.0)
            edge_ *= 1.25;
        for (int axis = 0; axis < 3; ++axis)
            counts_[axis] = static_cast<int>(cells_of(edge_)[axis]);
    } else {
        edge_ = extent.maxCoeff() + 1.0;
    }
    per_length_ = 1.0 / edge_;
    begins_.assign(static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2] + 1, 0);
    std::vector<int> cell(order_.size());
    for (std::size_t i = 0; i < cell.size(); ++i) {
        std::array<int, 3> at{};
        for (int axis = 0; axis < 3; ++axis) {
            const double x = centres(static_cast<Eigen::Index>(i), axis);
            at[axis] = std::min(cells(axis, x, x).begin, counts_[axis] - 1);
        }
        cell[i] = (at[2] * counts_[1] + at[1]) * counts_[0] + at[0];
        ++begins_[static_cast<std::size_t>(cell[i]) + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    std::vector<int> next(begins_.begin(), begins_.end() - 1);
    for (std::size_t i = 0; i < cell.size(); ++i)
        order_[static_cast<std::size_t>(next[cell[i]]++)] = static_cast<int>(i);
    for (std::size_t k = 0; k < order_.size(); ++k)
        centres_.row(static_cast<Eigen::Index>(k)) = centres.row(order_[k]);
}

} // namespace sinew
