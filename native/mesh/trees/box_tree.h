// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

#include <functional>
#include <queue>
#include <tuple>
#include <vector>

namespace sinew {

/// Boxes in a tree, for searches that begin with the best ones and soon end. Any number of threads may search
/// at once.
class BoxTree
{
public:
    using Box = Eigen::AlignedBox3d;

    /// Cost: O(n log^2 n).
    explicit BoxTree(const std::vector<Box>& boxes);

    /// Visits the boxes whose bound is below a limit, by rising bound, and of equal ones by rising index.
    /// Cost: a bound for each box that contains one of these, and for its two halves.
    /// \param end    only boxes of lower indices count.
    /// \param bound  bound(box, is_single) must be a lower bound of the value of every box inside.
    /// \param visit  visit(index) returns the limit from then on.
    template <class Bound, class Visit>
    void visit_by_bound(int end, double limit, Bound&& bound, Visit&& visit) const
    {
        // Of equal bounds, a box around several comes first: a lower index may be among these.
        using Entry = std::tuple<double, bool, int>; // the bound, whether it is a single box, which
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        const auto add = [&](int number) {
            const Node& node = nodes_[number];
            if (node.lowest >= end)
                return;
            if (const double least = bound(node.box, node.is_leaf()); least < limit)
                open.emplace(least, node.is_leaf(), node.is_leaf() ? node.lowest : number);
        };
        if (!nodes_.empty())
            add(0);
        while (!open.empty()) {
            const auto [least, is_single, number] = open.top();
            open.pop();
            if (!(least < limit))
                return;
            if (is_single) {
                limit = visit(number);
            } else {
                add(number + 1);
                add(nodes_[number].second);
            }
        }
    }

private:
    struct Node
    {
        Box box;
        int lowest;     ///< index of a box in it
        int second = 0; ///< of its halves; the first one is the next node

        bool is_leaf() const { return second == 0; }
    };

    void build(std::vector<int>::iterator begin, std::vector<int>::iterator end,
               const std::vector<Box>& boxes);

    std::vector<Node> nodes_;
};

} // namespace sinew
