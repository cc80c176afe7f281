// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/closest_triangle.h"

#include "native/core/parallel.h"
#include "native/core/space/space_order.h"
#include "native/mesh/trees/triangle_tree.h"

#include <algorithm>
#include <utility>

namespace sinew {

double squared_distance(const Vector3& point, const Vector3& a, const Vector3& b, const Vector3& c)
{
    const Vector3 ab = b - a, ac = c - a, ap = point - a;
    const double ab_a = ab.dot(ap), ac_a = ac.dot(ap);
    if (ab_a <= 0 && ac_a <= 0)
        return ap.squaredNorm();
    const Vector3 bp = point - b;
    const double ab_b = ab.dot(bp), ac_b = ac.dot(bp);
    if (ab_b >= 0 && ac_b <= ab_b)
        return bp.squaredNorm();
    const Vector3 cp = point - c;
    const double ab_c = ab.dot(cp), ac_c = ac.dot(cp);
    if (ac_c >= 0 && ab_c <= ac_c)
        return cp.squaredNorm();
    const double of_c = ab_a * ac_b - ab_b * ac_a; // barycentric, times twice the area squared
    if (of_c <= 0 && ab_a >= 0 && ab_b <= 0)
        return (ap - ab_a / (ab_a - ab_b) * ab).squaredNorm();
    const double of_b = ab_c * ac_a - ab_a * ac_c;
    if (of_b <= 0 && ac_a >= 0 && ac_c <= 0)
        return (ap - ac_a / (ac_a - ac_c) * ac).squaredNorm();
    const double of_a = ab_b * ac_c - ab_c * ac_b, along = ac_b - ab_b, back = ab_c - ac_c;
    if (of_a <= 0 && along >= 0 && back >= 0)
        return (bp - along / (along + back) * (c - b)).squaredNorm();
    const double sum = of_a + of_b + of_c;
    return (ap - of_b / sum * ab - of_c / sum * ac).squaredNorm();
}

ClosestTriangle::ClosestTriangle(const PointsView& points, const std::vector<Triangle>& triangles)
    : points_(points), triangles_(triangles)
{
    const int count = static_cast<int>(triangles.size());
    const auto corner = [&](int t, int k) -> Vector3 { return points.row(triangles[t][k]).transpose(); };
    Points centres(count, 3);
    std::vector<char> flat(count);
    parallel_for(count, [&](int t) {
        const Corners corners{corner(t, 0), corner(t, 1), corner(t, 2)};
        centres.row(t) = ((corners[0] + corners[1] + corners[2]) / 3).transpose();
        flat[t] = is_flat(corners);
    });
    order_ = space_order(view(centres));
    std::erase_if(order_, [&](int t) { return flat[t] != 0; });
    auto below = static_cast<int>(order_.size());
    do {
        std::vector<Box> boxes((below + width - 1) / width);
        parallel_for(static_cast<int>(boxes.size()), [&](int i) {
            for (int k = width * i; k < std::min(width * (i + 1), below); ++k)
                if (levels_.empty())
                    for (int c = 0; c < 3; ++c)
                        boxes[i].extend(corner(order_[k], c));
                else
                    boxes[i].extend(levels_.back()[k]);
        });
        below = static_cast<int>(boxes.size());
        levels_.push_back(std::move(boxes));
    } while (below > 1);
}

int ClosestTriangle::to(const Vector3& point, double limit) const
{
    struct Open
    {
        double least; ///< squared distance
        int level, box;
    };
    Open open[64]; // three are left at each of at most sixteen levels
    int top = 0, found = -1;
    double best = limit * limit;
    if (!levels_.back().empty())
        open[top++] = {0.0, static_cast<int>(levels_.size()) - 1, 0};
    while (top > 0) {
        const auto [least, level, box] = open[--top];
        if (least > best)
            continue;
        const int begin = width * box;
        if (level == 0) {
            const int end = std::min<int>(begin + width, static_cast<int>(order_.size()));
            for (int k = begin; k < end; ++k) {
                const auto [i, j, l] = triangles_[order_[k]];
                const double square =
                    squared_distance(point, points_.row(i).transpose(), points_.row(j).transpose(),
                                     points_.row(l).transpose());
                if (square < best || (square == best && (found < 0 || order_[k] < found))) {
                    best = square;
                    found = order_[k];
                }
            }
            continue;
        }
        const std::vector<Box>& boxes = levels_[level - 1];
        const int end = std::min<int>(begin + width, static_cast<int>(boxes.size())), first = top;
        for (int k = begin; k < end; ++k) {
            const Box& each = boxes[k];
            const double square =
                (each.min() - point).cwiseMax(point - each.max()).cwiseMax(0.0).squaredNorm();
            if (!(square <= best))
                continue;
            int at = top++;
            for (; at > first && open[at - 1].least < square; --at) // the nearest on top
                open[at] = open[at - 1];
            open[at] = {square, level - 1, k};
        }
    }
    return found;
}

} // namespace sinew
