// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/attachments.h"

#include "native/attachments/frames/attachment_frames.h"
#include "native/attachments/frames/feet.h"
#include "native/attachments/frames/moving_frames.h"
#include "native/attachments/loose_vertices.h"
#include "native/attachments/touching.h"
#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fits/rotation_fit.h"

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

/// A triangle of a part as vertices of the mesh.
Triangle of_mesh(const Triangle& t, const Part& part)
{
    return {part.vertices[t[0]], part.vertices[t[1]], part.vertices[t[2]]};
}

/// The corners of a patch as vertices of the mesh.
std::vector<Triangle> corners_of(const Patch& patch, const HostSurface& host)
{
    std::vector<Triangle> corners;
    for (int t : patch.triangles)
        corners.push_back(of_mesh(host.triangles()[t], host.part()));
    for (const Triangle& image : patch.images)
        corners.push_back(of_mesh(image, host.part()));
    return corners;
}

/// A part; its points and frames are those of its level.
struct AttachedPart
{
    int first_frame, frame_count;
    int first_point;
    bool is_row; ///< its vertices are numbered one after the other
};

/// One of four frames as a map, from where it sat to where it went.
struct Motion
{
    Matrix3 rotation;
    double scale;
    Vector3 from, to;

    Motion(const FourMotions& motions, const FourRests& rests, int lane) : scale(motions.scales[lane])
    {
        for (int k = 0; k < 9; ++k)
            rotation(k / 3, k % 3) = motions.rotations[k][lane];
        for (int k = 0; k < 3; ++k) {
            from[k] = rests.anchors[k][lane];
            to[k] = motions.anchors[k][lane];
        }
    }
};

FrameMap map_of(const Matrix3& A, const Vector3& from, const Vector3& to)
{
    const Vector3 t = to - A * from;
    FrameMap map{};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            map.columns[c][r] = A(r, c);
        map.columns[3][r] = t[r];
    }
    return map;
}

} // namespace

struct Attachments::Scratch
{
    AlignedVector<FourRests> rests; ///< of an incoming shape
    std::vector<FourMotions> motions;
    AlignedVector<FrameMap> maps;
};

/// Attachments whose hosts are in earlier levels.
struct Attachments::Level
{
    MovingFrames frames;
    FrameRests rests;
    std::vector<AttachedPart> attached_parts;
    std::vector<int> points; ///< vertices of all attached parts
    LooseVertices loose;
    // Of those with several frames:
    std::vector<int> bending; ///< attached parts
    std::vector<MatrixX> smoothing; ///< one each
    // The shares of point p are [offsets[p], offsets[p + 1]).
    std::vector<int> offsets{0}, share_frames;
    std::vector<double> shares;
    // Of points that follow the surface beneath them: those of foot_points[f] are [feet_ends[f - 1],
    // feet_ends[f]).
    std::vector<Foot> feet; ///< with corners of the mesh
    std::vector<int> foot_points, feet_ends;

    void add(const std::vector<int>& vertices, const MatrixX& vertex_shares, MatrixX frame_smoothing);
    /// The feet of the part that was added last. \param host  has their corners.
    void add_feet(const std::vector<Foot>& own, const Part& host);
    /// Where the frames of a part that bends sit.
    void find_origins(std::size_t attached_part, const PointsView& base, Vector3* origins) const;
    /// Makes the maps of a part that bends.
    void smooth(std::size_t number, const PointsView& base, const AlignedVector<FourRests>& base_rests,
                Scratch& scratch) const;
    /// Writes the points [begin, end).
    void carry(int begin, int end, const PointsView& base, const Scratch& scratch, Points& positions) const;
    /// Moves a point by what the maps have missed beneath it.
    void follow_feet(int number, const PointsView& base, const Scratch& scratch, Points& positions) const;

    int end_point(std::size_t attached_part) const
    {
        return attached_part + 1 < attached_parts.size() ? attached_parts[attached_part + 1].first_point
                                                         : static_cast<int>(points.size());
    }
};

void Attachments::Level::add(const std::vector<int>& vertices, const MatrixX& vertex_shares,
                             MatrixX frame_smoothing)
{
    const int frame_count = static_cast<int>(vertex_shares.rows());
    const int first_frame = frames.size() - frame_count;
    if (frame_count > 1) {
        bending.push_back(static_cast<int>(attached_parts.size()));
        smoothing.push_back(std::move(frame_smoothing));
    }
    const bool is_row =
        vertices.back() - vertices.front() + 1 == static_cast<int>(vertices.size()); // they rise
    attached_parts.push_back({first_frame, frame_count, static_cast<int>(points.size()), is_row});
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        points.push_back(vertices[v]);
        for (int k = 0; frame_count > 1 && k < frame_count; ++k)
            if (const double share = vertex_shares(k, static_cast<Eigen::Index>(v)); share > 0.0) {
                share_frames.push_back(first_frame + k);
                shares.push_back(share);
            }
        offsets.push_back(static_cast<int>(shares.size()));
    }
}

void Attachments::Level::add_feet(const std::vector<Foot>& own, const Part& host)
{
    const std::size_t count = points.size() - attached_parts.back().first_point;
    for (std::size_t v = 0; v < count; ++v) {
        for (std::size_t i = v; i < own.size(); i += count)
            if (own[i].share > 0.0) {
                feet.push_back(own[i]);
                feet.back().corners = of_mesh(own[i].corners, host);
            }
        if (feet.size() > (feet_ends.empty() ? 0u : feet_ends.back())) {
            foot_points.push_back(attached_parts.back().first_point + static_cast<int>(v));
            feet_ends.push_back(static_cast<int>(feet.size()));
        }
    }
}

void Attachments::Level::follow_feet(int number, const PointsView& base, const Scratch& scratch,
                                     Points& positions) const
{
    const int point = foot_points[number];
    Vector3 move = Vector3::Zero();
    for (int f = number > 0 ? feet_ends[number - 1] : 0; f < feet_ends[number]; ++f) {
        const Foot& foot = feet[f];
        Vector3 from = Vector3::Zero(), missed = Vector3::Zero();
        for (int k = 0; k < 3; ++k) {
            from += foot.parts[k] * base.row(foot.corners[k]).transpose();
            missed += foot.parts[k] * positions.row(foot.corners[k]).transpose();
        }
        for (int s = offsets[point]; s < offsets[point + 1]; ++s) {
            const auto& columns = scratch.maps[share_frames[s]].columns;
            for (int r = 0; r < 3; ++r)
                missed[r] -= shares[s] * (columns[0][r] * from[0] + columns[1][r] * from[1] +
                                          columns[2][r] * from[2] + columns[3][r]);
        }
        move += foot.share * missed;
    }
    positions.row(points[point]) += move.transpose();
}

void Attachments::Level::find_origins(std::size_t attached_part, const PointsView& base,
                                      Vector3* origins) const
{
    const auto& [first_frame, frame_count, first_point, is_row] = attached_parts[attached_part];
    const Vector3 from = base.row(points[first_point]).transpose();
    std::array<double, most_frames> sums{};
    for (int k = 0; k < frame_count; ++k)
        origins[k].setZero();
    for (int p = first_point; p < end_point(attached_part); ++p) {
        const Vector3 point = base.row(points[p]).transpose();
        for (int s = offsets[p]; s < offsets[p + 1]; ++s) {
            const int k = share_frames[s] - first_frame;
            origins[k] += shares[s] * (point - from);
            sums[k] += shares[s];
        }
    }
    for (int k = 0; k < frame_count; ++k)
        origins[k] = sums[k] > 0.0 ? Vector3(from + origins[k] / sums[k]) : from;
}

void Attachments::Level::smooth(std::size_t number, const PointsView& base,
                                const AlignedVector<FourRests>& base_rests, Scratch& scratch) const
{
    const std::size_t part = bending[number];
    const AttachedPart& attached_part = attached_parts[part];
    const MatrixX& weights = smoothing[number];
    std::array<Vector3, most_frames> origins, places;
    std::array<Matrix3, most_frames> rotations;
    std::array<double, most_frames> logs;
    find_origins(part, base, origins.data());
    for (int u = 0; u < attached_part.frame_count; ++u) {
        const int frame = attached_part.first_frame + u;
        const Motion motion(scratch.motions[frame / 4], base_rests[frame / 4], frame % 4);
        rotations[u] = motion.rotation;
        logs[u] = std::log(motion.scale);
        places[u] = motion.to + motion.scale * (motion.rotation * (origins[u] - motion.from)).eval();
    }
    for (int k = 0; k < attached_part.frame_count; ++k) {
        Matrix3 rotation = Matrix3::Zero();
        Vector3 origin = Vector3::Zero(), place = Vector3::Zero();
        double log_scale = 0.0;
        for (int u = 0; u < attached_part.frame_count; ++u) {
            const double share = weights(k, u);
            rotation += share * rotations[u];
            log_scale += share * logs[u];
            origin += share * origins[u];
            place += share * places[u];
        }
        scratch.maps[attached_part.first_frame + k] =
            map_of(std::exp(log_scale) * fit_rotation(rotation), origin, place);
    }
}

void Attachments::Level::carry(int begin, int end, const PointsView& base, const Scratch& scratch,
                               Points& positions) const
{
    const FrameKernels& kernels = widest_kernels<FrameKernels>();
    const auto after = std::ranges::upper_bound(attached_parts, begin, {}, &AttachedPart::first_point);
    for (std::size_t r = after - attached_parts.begin() - 1; begin < end; ++r) {
        const AttachedPart& attached_part = attached_parts[r];
        const int stop = std::min(end, end_point(r));
        const std::ptrdiff_t first = 3 * static_cast<std::ptrdiff_t>(points[begin]);
        if (attached_part.frame_count == 1 && attached_part.is_row)
            kernels.carry_row(scratch.maps[attached_part.first_frame], stop - begin, base.data() + first,
                              positions.data() + first);
        else if (attached_part.frame_count == 1)
            kernels.carry(scratch.maps[attached_part.first_frame], &points[begin], stop - begin, base.data(),
                          positions.data());
        else
            kernels.bend(scratch.maps.data(), &offsets[begin], share_frames.data(), shares.data(),
                         &points[begin], stop - begin, base.data(), positions.data());
        begin = stop;
    }
}

Attachments::Attachments(const SurfaceMesh& rest, const Components& parts, std::vector<bool> driven,
                         FreeParts options, const Progress& progress)
    : driven_(std::move(driven)), options_(std::move(options))
{
    check(options_.stiffness, rest.vertex_count());
    if (!options_.follow || std::ranges::all_of(driven_, std::identity()) ||
        std::ranges::none_of(driven_, std::identity()))
        return;
    HostedParts hosted{.labels = parts, .parts = parts_of(rest, parts), .attachments = {}, .surfaces = {}};
    Eigen::AlignedBox3d box;
    for (int p = 0; p < parts.count; ++p)
        if (driven_[p])
            box.extend(hosted.parts[p].box);
    const double diagonal = box.diagonal().norm(), length = bend_share * diagonal;
    hosted.attachments = find_hosts(hosted.parts, driven_, length, hosted.surfaces, progress);
    if (hosted.attachments.empty())
        return;
    const std::vector<int> hosts = join_where_they_touch(rest, hosted, length, progress);
    const std::vector<Part>& all = hosted.parts;
    const std::vector<Attachment>& attachments = hosted.attachments;
    const HostSurfaces& surfaces = hosted.surfaces;

    progress.tick(0.0, "laying out the frames of free parts");
    const int count = static_cast<int>(attachments.size());
    // Whether each part has parts attached to it: any that bend, any at all.
    std::vector<char> bent(all.size(), 0), carries(all.size(), 0);
    std::vector<FrameLayout> layouts(count);
    const auto is_loose = [&](int i) { return all[attachments[i].part].points.size() == 1; };
    const auto prepare = [&](const std::vector<char>& which, const auto& how) {
        parallel_for(
            static_cast<int>(all.size()),
            [&](int p) {
                if (which[p])
                    how(*surfaces[p]);
            },
            1);
    };
    for (int i = 0; i < count; ++i)
        carries[attachments[i].host] |= !is_loose(i);
    prepare(carries, [](HostSurface& surface) {
        surface.prepare_tree();
        surface.find_mirror_plane();
    });
    parallel_for(
        count,
        [&](int i) {
            const Part& part = all[attachments[i].part];
            if (!is_loose(i))
                layouts[i] = lay_out_frames(part, *surfaces[attachments[i].host], length,
                                            mean_stiffness(options_.stiffness, part.vertices));
        },
        8);
    for (int i = 0; i < count; ++i)
        bent[attachments[i].host] |= layouts[i].frame_count() > 1;
    prepare(bent, [](HostSurface& surface) { surface.prepare_edges(); });
    progress.tick(0.0, "finding the patches beneath free parts");
    std::vector<AttachmentFrames> made(count);
    std::vector<Triangle> carriers(count);
    parallel_for(
        count,
        [&](int i) {
            const Attachment& attachment = attachments[i];
            const HostSurface& host = *surfaces[attachment.host];
            if (is_loose(i))
                carriers[i] = carriers_of(host, attachment.beneath[0], all[attachment.part].points[0]);
            else
                made[i] = make_frames(attachment, all[attachment.part], host, layouts[i], 1e-12 * diagonal);
        },
        8);

    std::vector<int> depths(all.size(), 0); // hosts come before their attached parts
    std::vector<int> frame_counts(all.size());
    for (int i = 0; i < count; ++i) {
        const Attachment& attachment = attachments[i];
        const Part &part = all[attachment.part], &host = all[attachment.host];
        const int depth = depths[attachment.part] = depths[attachment.host] + 1;
        levels_.resize(std::max<std::size_t>(levels_.size(), depth));
        Level& level = levels_[depth - 1];
        if (is_loose(i)) {
            level.loose.add(part.vertices[0], of_mesh(carriers[i], host));
        } else {
            for (const Patch& patch : made[i].patches)
                level.frames.add(corners_of(patch, *surfaces[attachment.host]), patch.weights, patch.anchors);
            level.add(part.vertices, layouts[i].shares, std::move(made[i].smoothing));
            level.add_feet(made[i].feet, host);
        }
        frame_counts[attachment.part] = is_loose(i) ? 1 : layouts[i].frame_count();
    }
    std::vector<int> firsts(parts.count), sizes(parts.count, 0);
    for (int v = rest.vertex_count() - 1; v >= 0; --v) {
        firsts[parts.labels[v]] = v;
        ++sizes[parts.labels[v]];
    }
    for (int p = 0; p < parts.count; ++p)
        if (!driven_[p]) {
            const int together = hosted.labels.labels[firsts[p]];
            rides_.push_back({p, firsts[p], sizes[p], hosts[p], frame_counts[together]});
        }
    rest_ = rest.points();
    for (Level& level : levels_) {
        level.loose.measure(view(rest_));
        level.frames.resize(level.rests);
        for (int four = 0; four < level.frames.four_count(); ++four)
            level.frames.measure(four, view(rest_), level.rests);
    }
}

Attachments::~Attachments() = default;

void Attachments::move(const std::optional<PointsView>& incoming, Points& positions) const
{
    if (levels_.empty())
        return;
    std::unique_ptr<Scratch> kept = scratch_.take();
    Scratch& scratch = *kept;
    const PointsView base = incoming ? *incoming : view(rest_);
    for (const Level& level : levels_) {
        const MovingFrames& frames = level.frames;
        const AlignedVector<FourRests>& rests = incoming ? scratch.rests : level.rests.fours;
        if (incoming)
            scratch.rests.resize(frames.four_count());
        scratch.motions.resize(frames.four_count());
        scratch.maps.resize(4 * scratch.motions.size());
        const PointsView deformed = view(positions);
        parallel_for(
            frames.four_count(),
            [&](int four) {
                scratch.motions[four] = incoming ? frames.fit(four, base, deformed, scratch.rests[four])
                                                 : frames.fit(four, level.rests, deformed);
                for (int lane = 0; lane < 4; ++lane) {
                    const Motion motion(scratch.motions[four], rests[four], lane);
                    scratch.maps[4 * four + lane] =
                        map_of(motion.scale * motion.rotation, motion.from, motion.to);
                }
            },
            32);
        parallel_for(
            static_cast<int>(level.bending.size()), [&](int b) { level.smooth(b, base, rests, scratch); }, 4);
        parallel_chunks(static_cast<int>(level.points.size()), 4096,
                        [&](int begin, int end) { level.carry(begin, end, base, scratch, positions); });
        parallel_for(
            static_cast<int>(level.foot_points.size()),
            [&](int f) { level.follow_feet(f, base, scratch, positions); }, 256);
        level.loose.move(incoming, positions);
    }
    scratch_.give_back(std::move(kept));
}

} // namespace sinew
