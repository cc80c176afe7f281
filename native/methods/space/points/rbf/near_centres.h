// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sinew {

/// Centres in the order of the cells of a grid, so that those within reach of a box are few runs of this
/// order.
class NearCentres
{
public:
    NearCentres() = default;
    /// Cost: O(c).
    /// \param reach  > 0; infinite for centres that reach everywhere, whose only run is all of them.
    NearCentres(const Points& centres, double reach);

    /// (c) the centres in this order.
    const std::vector<int>& order() const { return order_; }
    /// (c, 3) and where they are.
    const Points& centres() const { return centres_; }

    /// visit(begin, end) gets the runs that hold all centres nearer to the box than the reach, and others.
    template <class Visit>
    void visit(const Vector3& low, const Vector3& high, Visit&& visit) const
    {
        const auto [z_begin, z_end] = cells(2, low[2] - reach_, high[2] + reach_);
        const auto [y_begin, y_end] = cells(1, low[1] - reach_, high[1] + reach_);
        for (int z = z_begin; z < z_end; ++z)
            for (int y = y_begin; y < y_end; ++y) {
                const double left =
                    reach_ * reach_ - square(distance(2, z, low, high)) - square(distance(1, y, low, high));
                if (!(left > 0.0))
                    continue;
                const double along = std::sqrt(left);
                const auto [x_begin, x_end] = cells(0, low[0] - along, high[0] + along);
                const int row = (z * counts_[1] + y) * counts_[0];
                if (const int begin = begins_[row + x_begin], end = begins_[row + x_end]; begin < end)
                    visit(begin, end);
            }
    }

private:
    struct Range
    {
        int begin, end;
    };
    static double square(double x) { return x * x; }
    /// The cells that an interval meets.
    Range cells(int axis, double from, double to) const
    {
        const auto cell = [&](double x) {
            const double place = (x - corner_[axis]) * per_length_;
            return static_cast<int>(std::clamp(place, -1.0, 1.0 * counts_[axis]) + 1.0) - 1;
        };
        const int last = cell(to);
        return {std::max(0, cell(from)), last < 0 ? 0 : std::min(last + 1, counts_[axis])};
    }
    /// From a layer of cells to the box, along an axis.
    double distance(int axis, int cell, const Vector3& low, const Vector3& high) const
    {
        const double begin = corner_[axis] + cell * edge_;
        return std::max({0.0, begin - high[axis], low[axis] - (begin + edge_)});
    }

    double reach_ = 1.0, edge_ = 1.0, per_length_ = 1.0; ///< cells per length
    Vector3 corner_ = Vector3::Zero();
    std::array<int, 3> counts_{1, 1, 1};
    std::vector<int> order_, begins_; ///< where the centres of each cell begin, x by x
    Points centres_;
};

} // namespace sinew
