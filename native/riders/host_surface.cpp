// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/host_surface.h"

#include <algorithm>
#include <cmath>

namespace sinew {

HostSurface::HostSurface(const Part& part) : part_(&part), offsets_(part.points.size() + 1, 0)
{
    const double least = 1e-10 * std::ranges::max(part.areas);
    double sum = 0.0;
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
        if (part.areas[i] <= least)
            continue;
        const Triangle& t = part.triangles[i];
        triangles_.push_back(t);
        areas_.push_back(part.areas[i]);
        sum += part.areas[i];
        centres_.emplace_back((part.points[t[0]] + part.points[t[1]] + part.points[t[2]]) / 3);
        for (int v : t)
            ++offsets_[v + 1];
    }
    spacing_ = std::sqrt(2 * sum / static_cast<double>(triangles_.size()));
    for (std::size_t v = 0; v < part.points.size(); ++v)
        offsets_[v + 1] += offsets_[v];
    around_.resize(3 * triangles_.size());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
        for (int v : triangles_[t])
            around_[next[v]++] = t;
}

} // namespace sinew
