// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/sampling.h"

#include <limits>

namespace sinew {

std::vector<int> farthest_points(const std::vector<Vector3>& points, int count, int first)
{
    std::vector<double> distances(points.size(), std::numeric_limits<double>::infinity());
    std::vector<int> chosen;
    for (int next = first; static_cast<int>(chosen.size()) < count;) {
        chosen.push_back(next);
        const Vector3& at = points[next];
        double farthest = 0.0;
        for (int i = 0; i < static_cast<int>(points.size()); ++i) {
            distances[i] = std::min(distances[i], (points[i] - at).squaredNorm());
            if (distances[i] >
                farthest * (1 + 1e-9)) { // of those that are equal but for rounding, the lowest
                farthest = distances[i];
                next = i;
            }
        }
        if (farthest == 0.0)
            break;
    }
    return chosen;
}

} // namespace sinew
