// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/method.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/core/system/memory_advice.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <typeinfo>
#include <utility>

namespace sinew {

namespace {

std::vector<int> not_finite(const PointsView& points)
{
    std::vector<int> bad;
    for (int i = 0; i < points.rows(); ++i)
        if (!points.row(i).allFinite())
            bad.push_back(i);
    return bad;
}

/// A copy whose page faults the threads share, and whether all of it is finite.
bool copy(const PointsView& from, Points& to)
{
    std::atomic<bool> finite = true;
    to.resize(from.rows(), 3);
    ask_for_large_pages(to.data(), sizeof(double) * static_cast<std::size_t>(to.size()));
    parallel_chunks(static_cast<int>(from.rows()), 1 << 13, [&](int begin, int end) {
        auto some = to.middleRows(begin, end - begin);
        some = from.middleRows(begin, end - begin);
        if (!all_finite(some))
            finite = false;
    });
    return finite;
}

} // namespace

SpaceReport SpaceMethod::bind(PointsView points, const Progress& progress)
{
    const AccessLock alone(AccessLock::changing, access_);
    return hold(points, progress);
}

SpaceReport SpaceMethod::hold(PointsView points, const Progress& progress)
{
    const auto begin = std::chrono::steady_clock::now();
    Points own;
    if (!copy(points, own)) {
        const std::vector<int> bad = not_finite(points);
        throw InvalidConstraint("points " + list_some(bad) + " are not finite", Error::Element::vertex, bad);
    }
    SpaceReport report;
    report.point_count = static_cast<int>(points.rows());
    compute(points, report, progress);
    points_.swap(own);
    bound_ = true;
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    report_ = report;
    return report;
}

std::vector<std::string> SpaceMethod::differences(const SpaceMethod& former, const PointsView& points) const
{
    if (typeid(*this) != typeid(former))
        return {"method"};
    std::vector<std::string> changed = changed_settings(former);
    const bool same_points =
        former.bound_ && points.rows() == former.points_.rows() &&
        std::memcmp(points.data(), former.points_.data(), sizeof(double) * points.size()) == 0;
    if (!same_points)
        changed.emplace_back("points");
    return changed;
}

bool SpaceMethod::can_reuse(const SpaceMethod& former, const PointsView& points) const
{
    const AccessLock both(AccessLock::reading, access_, former.access_);
    return differences(former, points).empty();
}

SpaceReport SpaceMethod::rebind(SpaceMethod& former, PointsView points, const Progress& progress)
{
    const AccessLock alone(AccessLock::changing, access_, former.access_);
    const std::vector<std::string> changed = differences(former, points);
    if (!changed.empty()) {
        SpaceReport report = hold(points, progress);
        report.changed = joined(changed);
        return report;
    }
    progress.tick(1.0, "taking over the weights");
    if (&former != this) {
        swap_all(former);
        former.bound_ = false;
    }
    SpaceReport report = report_;
    report.reuse = Reuse::kept;
    return report;
}

void SpaceMethod::swap_all(SpaceMethod& other)
{
    swap_weights(other);
    std::swap(points_, other.points_);
    std::swap(report_, other.report_);
    std::swap(bound_, other.bound_);
}

void SpaceMethod::warp(PointsView control, const std::optional<PointsView>& incoming, PositionsOut out,
                       std::optional<Eigen::Index> room) const
{
    const AccessLock shared = reading();
    displace(control, checked_base(incoming, room), out);
}

PointsView SpaceMethod::checked_base(const std::optional<PointsView>& incoming,
                                     std::optional<Eigen::Index> room) const
{
    if (!bound_)
        throw InvalidConstraint(std::string("no points are bound to the ") + control_name() +
                                ": call bind() first");
    if (room.value_or(points_.rows()) != points_.rows())
        throw InvalidConstraint("out: room for " + std::to_string(*room) + " points, and " +
                                std::to_string(points_.rows()) + " are bound");
    if (incoming) {
        if (incoming->rows() != points_.rows())
            throw InvalidConstraint("incoming: " + std::to_string(incoming->rows()) + " points given for " +
                                    std::to_string(points_.rows()) + " bound ones");
        if (!all_finite(*incoming)) {
            const std::vector<int> bad = not_finite(*incoming);
            throw InvalidConstraint("incoming: NaN or infinite coordinates at vertices " + list_some(bad),
                                    Error::Element::vertex, bad);
        }
    }
    return incoming ? *incoming : view(points_);
}

} // namespace sinew
