// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_outside.h"

#include <algorithm>

namespace sinew {

OutsideWeights::OutsideWeights(const Cage& cage, CageOutside choice)
{
    if (choice == CageOutside::mean_value)
        mean_value_.emplace(cage);
}

void OutsideWeights::fill(PointsView block, const std::vector<char>& outside, RowMatrix& rows) const
{
    const auto count = std::count(outside.begin(), outside.end(), 1);
    if (count == 0 || !mean_value_)
        return;
    Points points(count, 3);
    RowMatrix weights;
    std::vector<char> unused;
    for (Eigen::Index i = 0, k = 0; i < block.rows(); ++i)
        if (outside[static_cast<std::size_t>(i)])
            points.row(k++) = block.row(i);
    mean_value_->evaluate(0, view(points), weights, unused);
    for (Eigen::Index i = 0, k = 0; i < block.rows(); ++i)
        if (outside[static_cast<std::size_t>(i)])
            rows.row(i) = weights.row(k++);
}

} // namespace sinew
