// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/inside/outside_weights.h"

#include "native/methods/space/cage/closed_forms/mean_value_weights.h"

#include <algorithm>

namespace sinew {

OutsideWeights::OutsideWeights(const Cage& cage, CageOutside choice)
{
    if (choice == CageOutside::mean_value) {
        geometry_.emplace(cage);
        smooth_ = cage.smooth();
    }
}

void OutsideWeights::fill(PointsView block, const std::vector<char>& outside, RowMatrix& rows) const
{
    const auto count = std::count(outside.begin(), outside.end(), 1);
    if (count == 0 || !geometry_)
        return;
    Points points(count, 3);
    RowMatrix weights;
    std::vector<char> unused;
    for (Eigen::Index i = 0, k = 0; i < block.rows(); ++i)
        if (outside[static_cast<std::size_t>(i)])
            points.row(k++) = block.row(i);
    mean_value_weights(*geometry_, view(points), weights, unused);
    if (smooth_)
        smooth_->fold(weights);
    for (Eigen::Index i = 0, k = 0; i < block.rows(); ++i)
        if (outside[static_cast<std::size_t>(i)])
            rows.row(i) = weights.row(k++);
}

} // namespace sinew
