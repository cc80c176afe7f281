// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/handles/handle_method.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

namespace sinew {

namespace {

/// The rigid motion that takes points closest to others: three columns and the translation.
Pose rigid_fit(const Points& from, const Points& to)
{
    const Eigen::RowVector3d centre = from.colwise().mean(), target = to.colwise().mean();
    const Matrix3 S = (to.rowwise() - target).transpose() * (from.rowwise() - centre);
    Pose fit;
    fit.leftCols<3>() = fit_rotation(S);
    fit.col(3) = target.transpose() - fit.leftCols<3>() * centre.transpose();
    return fit;
}

} // namespace

std::vector<int> nearest_points(const Points& places, PointsView points)
{
    std::map<std::array<double, 3>, int> wanted;
    std::vector<int> found(static_cast<std::size_t>(places.rows()), -1);
    const auto key = [](const auto& row) { return std::array<double, 3>{row[0], row[1], row[2]}; };
    for (Eigen::Index k = 0; k < places.rows(); ++k)
        wanted.emplace(key(places.row(k)), -1);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        if (const auto at = wanted.find(key(points.row(i))); at != wanted.end() && at->second < 0)
            at->second = static_cast<int>(i);
    parallel_for(
        static_cast<int>(places.rows()),
        [&](int k) {
            found[k] = wanted.at(key(places.row(k)));
            if (found[k] < 0 && points.rows() > 0) {
                Eigen::Index nearest = 0;
                (points.rowwise() - places.row(k)).rowwise().squaredNorm().minCoeff(&nearest);
                found[k] = static_cast<int>(nearest);
            }
        },
        1);
    return found;
}

HandleMethod::HandleMethod(SurfaceMesh surface, HandlePoints held)
    : SpaceMethod("handles"), surface_(std::move(surface)), centre_(surface_frame(surface_).centre),
      unit_(surface_frame(surface_).size), control_(std::move(held), centre_, unit_)
{
}

SurfaceMesh HandleMethod::surface_in_unit() const
{
    std::vector<int> counts, corners;
    for (int f = 0; f < surface_.face_count(); ++f) {
        counts.push_back(static_cast<int>(surface_.face(f).size()));
        corners.insert(corners.end(), surface_.face(f).begin(), surface_.face(f).end());
    }
    return {in_unit(view(surface_.points())), std::move(counts), std::move(corners)};
}

void HandleMethod::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    std::vector<int> carriers = nearest_points(control_.held().points(), points);
    build(points, report, progress);
    carriers_ = std::move(carriers);
}

void HandleMethod::displace(PointsView control, PointsView base, PositionsOut out) const
{
    write(control_.motions(control), base, out);
}

void HandleMethod::write(const std::vector<HeldMotion>& motions, PointsView base, PositionsOut out) const
{
    const auto rests = [](const HeldMotion& m) { return m.turn.isZero(0.0) && m.move.isZero(0.0); };
    if (base.rows() == 0)
        return;
    if (std::ranges::all_of(motions, rests)) // the least energy, 0, is that of the shape that enters
        std::visit([&](auto* to) { std::copy(base.data(), base.data() + base.size(), to); }, out);
    else
        deform(motions, base, enters(base), out);
}

std::vector<HeldMotion> HandleMethod::aimed(const Poses& poses, PointsView base,
                                            const std::vector<bool>& from_rest) const
{
    if (!from_rest.empty() && from_rest.size() != poses.size())
        throw InvalidConstraint("from_rest: " + std::to_string(from_rest.size()) + " flags given for " +
                                std::to_string(poses.size()) + " handles");
    Poses result = poses;
    if (enters(base) && base.rows() > 0 && static_cast<int>(poses.size()) == control_.count())
        for (int h = 0; h < control_.count(); ++h)
            if (!from_rest.empty() && from_rest[h]) {
                // What has moved the incoming shape has moved the control, too.
                const int first = control_.held().begin(h), count = control_.held().count(h);
                Points before(count, 3), now(count, 3);
                for (int k = 0; k < count; ++k) {
                    before.row(k) = points().row(carriers_[first + k]);
                    now.row(k) = base.row(carriers_[first + k]);
                }
                const Pose fit = rigid_fit(before, now);
                result[h].leftCols<3>() = poses[h].leftCols<3>() * fit.leftCols<3>().transpose();
                result[h].col(3) = poses[h].col(3) - result[h].leftCols<3>() * fit.col(3);
            }
    return control_.motions(result);
}

void HandleMethod::warp_poses(const Poses& poses, const std::optional<PointsView>& incoming, PositionsOut out,
                              std::optional<Eigen::Index> room, const std::vector<bool>& from_rest) const
{
    const AccessLock shared = reading();
    const PointsView base = checked_base(incoming, room);
    write(aimed(poses, base, from_rest), base, out);
}

HandleMethod::Network HandleMethod::network(const Poses& poses, const std::optional<PointsView>& incoming,
                                            const std::vector<bool>& from_rest) const
{
    const AccessLock shared = reading();
    const PointsView base = checked_base(incoming, {});
    return posed_network(aimed(poses, base, from_rest), base, enters(base));
}

SolveReport HandleMethod::report_for(const Poses& poses) const
{
    const AccessLock shared = reading();
    const PointsView base = checked_base({}, {});
    Points out(base.rows(), 3);
    return deform(control_.motions(poses), base, false, out.data());
}

void HandleMethod::swap_weights(SpaceMethod& other)
{
    auto& others = static_cast<HandleMethod&>(other);
    std::swap(carriers_, others.carriers_);
    swap_binding(others);
}

std::vector<std::string> HandleMethod::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const HandleMethod&>(former);
    return names_of({{"surface", !(surface_ == other.surface_)},
                     {"handles", !(control_.held() == other.control_.held())}});
}

} // namespace sinew
