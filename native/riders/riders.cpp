// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/riders.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/operators/rotation_fit.h"
#include "native/riders/rider_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double bend_share = 0.06; ///< of the diagonal of the driven parts

/// \throw InvalidOption
void check(const std::vector<double>& stiffness, int vertex_count)
{
    if (stiffness.size() != 1 && static_cast<int>(stiffness.size()) != vertex_count)
        throw InvalidOption("free_part_stiffness: " + std::to_string(stiffness.size()) +
                            " values given; 1 or one per vertex (" + std::to_string(vertex_count) +
                            ") needed");
    std::vector<int> bad;
    for (int v = 0; v < static_cast<int>(stiffness.size()); ++v)
        if (!(stiffness[v] >= 0.0 && stiffness[v] <= 1.0))
            bad.push_back(v);
    if (!bad.empty() && stiffness.size() == 1)
        throw InvalidOption("free_part_stiffness: " + std::to_string(stiffness[0]) + " is not in [0, 1]");
    if (!bad.empty())
        throw InvalidOption("free_part_stiffness: values at vertices " + list_some(bad) +
                                " are not in [0, 1]",
                            Error::Element::vertex, bad);
}

double mean_stiffness(const std::vector<double>& stiffness, const std::vector<int>& vertices)
{
    if (stiffness.size() == 1)
        return stiffness[0];
    double sum = 0.0;
    for (int v : vertices)
        sum += stiffness[v];
    return sum / static_cast<double>(vertices.size());
}

/// The corners of a patch as vertices of the mesh.
std::vector<Triangle> corners_of(const Patch& patch, const HostSurface& host)
{
    std::vector<Triangle> corners;
    for (int t : patch.triangles) {
        const auto& [a, b, c] = host.triangles()[t];
        const std::vector<int>& vertices = host.part().vertices;
        corners.push_back({vertices[a], vertices[b], vertices[c]});
    }
    return corners;
}

/// Linear and constant part of one frame's motion: v -> A v + t.
struct Map
{
    std::array<double, 12> entries; ///< A row by row, then t

    explicit Map(const FrameMotion& motion)
    {
        const Matrix3 A = std::exp(motion.log_scale) * motion.rotation;
        const Vector3 t = motion.place - A * motion.origin;
        for (int k = 0; k < 9; ++k)
            entries[k] = A(k / 3, k % 3);
        for (int k = 0; k < 3; ++k)
            entries[9 + k] = t[k];
    }
    Map() = default;
};

} // namespace

/// Kept from frame to frame, so that a frame allocates nothing.
struct Riders::Scratch
{
    std::vector<FrameMotion> motions;
    std::vector<Map> maps;
    std::vector<Vector3> origins;
};

Riders::Riders(const SurfaceMesh& rest, const Components& parts, std::vector<bool> driven, FreeParts options,
               const Progress& progress)
    : driven_(std::move(driven)), options_(std::move(options))
{
    check(options_.stiffness, rest.vertex_count());
    if (!options_.follow || std::ranges::all_of(driven_, std::identity()) ||
        std::ranges::none_of(driven_, std::identity()))
        return;
    const std::vector<Part> all = parts_of(rest, parts);
    Eigen::AlignedBox3d box;
    for (int p = 0; p < parts.count; ++p)
        if (driven_[p])
            box.extend(all[p].box);
    const double diagonal = box.diagonal().norm(), length = bend_share * diagonal;
    HostSurfaces surfaces;
    const std::vector<Seat> seats = find_seats(all, driven_, length, surfaces, progress);
    if (seats.empty())
        return;

    progress.tick(0.0, "laying out the frames of free parts");
    const int count = static_cast<int>(seats.size());
    std::vector<char> bent(all.size(), 0);
    std::vector<FrameLayout> layouts(count);
    parallel_for(
        count,
        [&](int i) {
            const Part& part = all[seats[i].part];
            layouts[i] = lay_out_frames(part, *surfaces[seats[i].host], length,
                                        mean_stiffness(options_.stiffness, part.vertices));
        },
        8);
    for (int i = 0; i < count; ++i)
        bent[seats[i].host] |= layouts[i].frame_count() > 1;
    parallel_for(
        parts.count,
        [&](int p) {
            if (bent[p])
                surfaces[p]->prepare_edges();
        },
        1);
    progress.tick(0.0, "finding the patches beneath free parts");
    std::vector<RiderFrames> made(count);
    parallel_for(
        count,
        [&](int i) {
            const Seat& seat = seats[i];
            made[i] = make_frames(seat, all[seat.part], *surfaces[seat.host], layouts[i], 1e-12 * diagonal);
        },
        8);

    std::vector<int> depths(all.size(), 0); // hosts come before their riders
    int deepest = 0;
    for (const Seat& seat : seats)
        deepest = std::max(deepest, depths[seat.part] = depths[seat.host] + 1);
    rest_ = rest.points();
    for (int depth = 1; depth <= deepest; ++depth) {
        const int first = static_cast<int>(riders_.size());
        for (int i = 0; i < count; ++i) {
            const Seat& seat = seats[i];
            if (depths[seat.part] != depth)
                continue;
            for (const Patch& patch : made[i].patches)
                frames_.add(corners_of(patch, *surfaces[seat.host]), patch.weights, patch.anchors);
            add(all[seat.part].vertices, layouts[i].shares, std::move(made[i].smoothing));
            rides_.push_back({seat.part, all[seat.part].vertices.front(),
                              static_cast<int>(all[seat.part].vertices.size()), seat.host,
                              layouts[i].frame_count()});
        }
        levels_.push_back({first, static_cast<int>(riders_.size())});
    }
    std::ranges::sort(rides_, {}, &Ride::part);
    std::vector<Vector3> origins(frames_.size());
    for (const Rider& rider : riders_)
        origins_of(rider, view(rest_), origins);
    for (int k = 0; k < frames_.size(); ++k)
        rests_.push_back(frames_.rest(k, view(rest_), origins[k]));
}

void Riders::add(const std::vector<int>& vertices, const MatrixX& shares, MatrixX smoothing)
{
    const int frame_count = static_cast<int>(shares.rows());
    const int first_frame = frames_.size() - frame_count;
    riders_.push_back({first_frame, frame_count, static_cast<int>(points_.size()),
                       static_cast<int>(vertices.size()), std::move(smoothing)});
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        points_.push_back(vertices[v]);
        for (int k = 0; k < frame_count; ++k)
            if (const double share = shares(k, static_cast<Eigen::Index>(v)); share > 0.0) {
                share_frames_.push_back(first_frame + k);
                shares_.push_back(share);
            }
        offsets_.push_back(static_cast<int>(shares_.size()));
    }
}

void Riders::origins_of(const Rider& rider, const PointsView& base, std::vector<Vector3>& origins) const
{
    const Vector3 from = base.row(points_[rider.first_point]).transpose();
    std::array<double, 64> sums{};
    for (int k = 0; k < rider.frame_count; ++k)
        origins[rider.first_frame + k].setZero();
    for (int p = rider.first_point; p < rider.first_point + rider.point_count; ++p) {
        const Vector3 point = base.row(points_[p]).transpose();
        for (int s = offsets_[p]; s < offsets_[p + 1]; ++s) {
            origins[share_frames_[s]] += shares_[s] * (point - from);
            sums[share_frames_[s] - rider.first_frame] += shares_[s];
        }
    }
    for (int k = 0; k < rider.frame_count; ++k) {
        Vector3& origin = origins[rider.first_frame + k];
        origin = sums[k] > 0.0 ? Vector3(from + origin / sums[k]) : from;
    }
}

void Riders::smooth(const Rider& rider, Scratch& scratch) const
{
    const int first = rider.first_frame;
    for (int k = 0; k < rider.frame_count; ++k) {
        FrameMotion sum{Matrix3::Zero(), 0.0, Vector3::Zero(), Vector3::Zero()};
        for (int u = 0; u < rider.frame_count; ++u) {
            const FrameMotion& motion = scratch.motions[first + u];
            const double share = rider.smoothing(k, u);
            sum.rotation += share * motion.rotation;
            sum.log_scale += share * motion.log_scale;
            sum.origin += share * motion.origin;
            sum.place += share * motion.place;
        }
        sum.rotation = fit_rotation(sum.rotation);
        scratch.maps[first + k] = Map(sum);
    }
}

void Riders::move(const std::optional<PointsView>& incoming, Points& positions) const
{
    if (riders_.empty())
        return;
    thread_local Scratch kept;
    Scratch scratch = std::exchange(kept, {}); // while this thread waits, it may run another solve
    scratch.motions.resize(frames_.size());
    scratch.maps.resize(frames_.size());
    scratch.origins.resize(incoming ? frames_.size() : 0);
    const PointsView base = incoming ? *incoming : view(rest_);
    for (const Level& level : levels_) {
        const Rider &front = riders_[level.first_rider], &back = riders_[level.end_rider - 1];
        const int first_frame = front.first_frame, first_point = front.first_point;
        if (incoming)
            parallel_for(
                level.end_rider - level.first_rider,
                [&](int r) { origins_of(riders_[level.first_rider + r], base, scratch.origins); }, 64);
        const PointsView deformed = view(positions);
        parallel_for(
            back.first_frame + back.frame_count - first_frame,
            [&](int f) {
                const int k = first_frame + f;
                scratch.motions[k] =
                    incoming ? frames_.move(k, frames_.rest(k, base, scratch.origins[k]), deformed)
                             : frames_.move(k, rests_[k], deformed);
            },
            128);
        parallel_for(
            level.end_rider - level.first_rider,
            [&](int r) {
                const Rider& rider = riders_[level.first_rider + r];
                if (rider.frame_count == 1)
                    scratch.maps[rider.first_frame] = Map(scratch.motions[rider.first_frame]);
                else
                    smooth(rider, scratch);
            },
            64);
        parallel_for(
            back.first_point + back.point_count - first_point,
            [&](int i) {
                const int p = first_point + i;
                const double* v = base.data() + 3 * static_cast<std::ptrdiff_t>(points_[p]);
                double* out = positions.data() + 3 * static_cast<std::ptrdiff_t>(points_[p]);
                double sum[3] = {0.0, 0.0, 0.0};
                for (int s = offsets_[p]; s < offsets_[p + 1]; ++s) {
                    const std::array<double, 12>& m = scratch.maps[share_frames_[s]].entries;
                    for (int c = 0; c < 3; ++c)
                        sum[c] += shares_[s] *
                                  (m[3 * c] * v[0] + m[3 * c + 1] * v[1] + m[3 * c + 2] * v[2] + m[9 + c]);
                }
                for (int c = 0; c < 3; ++c)
                    out[c] = sum[c];
            },
            4096);
    }
    kept = std::move(scratch);
}

} // namespace sinew
