// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/placing.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <chrono>
#include <string>

namespace sinew {

PlacedPoints placed_points(PointsView points, int cells,
                           const std::function<LatticePlace(const Vector3&)>& where, SpaceReport& report,
                           const Progress& progress)
{
    using Clock = std::chrono::steady_clock;
    constexpr const char* stage = "placing points in the lattice";
    const int count = static_cast<int>(points.rows());
    require_memory(static_cast<std::int64_t>(sizeof(LatticePlace)) * count, "the places of the points");
    std::vector<LatticePlace> places(static_cast<std::size_t>(count));
    int slab = 1024;
    for (int first = 0; first < count;) {
        progress.tick(static_cast<double>(first) / count, stage);
        const auto begin = Clock::now();
        const int some = std::min(slab, count - first);
        parallel_for(
            some,
            [&](int i) {
                const auto at = static_cast<std::size_t>(first + i);
                places[at] = where(points.row(first + i).transpose());
            },
            256);
        first += some;
        if (std::chrono::duration<double>(Clock::now() - begin).count() < 0.05)
            slab = std::min(2 * slab, 1 << 20);
    }
    for (int i = 0; i < count; ++i)
        if (places[static_cast<std::size_t>(i)].outside)
            report.outside.push_back(i);
    PlacedPoints placed(places, cells);
    progress.tick(1.0, stage);
    return placed;
}

void check_pose_of(const char* control, PointsView posed, int expected)
{
    if (posed.rows() != expected)
        throw InvalidConstraint(std::string("the ") + control + " was bound with " +
                                std::to_string(expected) + " points, and posed with " +
                                std::to_string(posed.rows()) + ": bind again");
    std::vector<int> bad;
    for (int i = 0; i < posed.rows(); ++i)
        if (!posed.row(i).allFinite())
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidConstraint(std::string("points ") + list_some(bad) + " of the " + control +
                                    " are not finite",
                                Error::Element::vertex, bad);
}

} // namespace sinew
