// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/box_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace sinew {

BoxTree::BoxTree(const std::vector<Box>& boxes)
{
    std::vector<int> order(boxes.size());
    std::iota(order.begin(), order.end(), 0);
    nodes_.reserve(2 * boxes.size());
    if (!order.empty())
        build(order.begin(), order.end(), boxes);
}

void BoxTree::build(std::vector<int>::iterator begin, std::vector<int>::iterator end,
                    const std::vector<Box>& boxes)
{
    const std::size_t own = nodes_.size();
    Box all, centres;
    for (auto i = begin; i != end; ++i) {
        all.extend(boxes[*i]);
        centres.extend(boxes[*i].center());
    }
    nodes_.push_back({all, *std::min_element(begin, end)});
    if (end - begin == 1)
        return;
    Eigen::Index axis = 0;
    centres.sizes().maxCoeff(&axis);
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](int i, int j) {
        return std::pair(boxes[i].center()[axis], i) < std::pair(boxes[j].center()[axis], j);
    });
    build(begin, middle, boxes);
    nodes_[own].second = static_cast<int>(nodes_.size());
    build(middle, end, boxes);
}

} // namespace sinew
