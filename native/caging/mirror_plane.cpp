// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/mirror_plane.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

MirrorTest::MirrorTest(const std::vector<Vector3>& points, int count, const TriangleTree& tree)
    : points_(points), count_(count), tree_(tree)
{
}

double MirrorTest::deviation(int axis, double offset, int step) const
{
    std::vector<double> distances((count_ + step - 1) / step);
    parallel_for(
        static_cast<int>(distances.size()),
        [&](int i) {
            Vector3 p = points_[i * step];
            p[axis] = 2.0 * offset - p[axis];
            distances[i] = (tree_.closest(p) - p).norm();
        },
        64);
    return *std::ranges::max_element(distances);
}

MirrorPlane MirrorTest::best(const Vector3& origin, int axis, double tolerance) const
{
    constexpr double alike = 1e-3;
    const auto step = [&](int samples) { return std::max(1, count_ / samples); };
    MirrorPlane best{.deviation = std::numeric_limits<double>::infinity()};
    for (int k = 0; k < 3; ++k) {
        if (axis >= 0 && k != axis)
            continue;
        for (bool through_origin : {true, false}) {
            // The mirror image of the box about a plane far from its middle lies elsewhere.
            if (through_origin && std::abs(origin[k]) > tolerance)
                continue;
            const double offset = through_origin ? origin[k] : 0.0;
            const double found = deviation(k, offset, step(100));
            if (found < best.deviation - alike)
                best = {k, offset, found, through_origin};
        }
    }
    for (int samples : {2000, count_})
        if (best.deviation <= tolerance || samples == 2000)
            best.deviation = deviation(best.axis, best.offset, step(samples));
    return best;
}

} // namespace sinew
