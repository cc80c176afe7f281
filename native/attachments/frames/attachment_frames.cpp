// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/attachment_frames.h"

#include "native/attachments/frames/moving_frames.h"
#include "native/core/parallel.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace sinew {

namespace {

constexpr double smoothness = 0.1; // mu
constexpr double far_away = 8.0;   // in edges of the host

/// What lies beneath one frame.
struct Footprint
{
    std::vector<Contact> contacts;
    int best = 0; ///< the heaviest contact
    double gap = 0.0, radius = 0.0;
};

Footprint footprint_of(int frame, const Attachment& attachment, const Part& part, const HostSurface& host,
                       const FrameLayout& layout, double tiny)
{
    const std::size_t count = attachment.samples.size();
    std::vector<double> shares(count);
    for (std::size_t i = 0; i < count; ++i)
        shares[i] = layout.shares(frame, attachment.samples[i]);
    double most = std::ranges::max(shares);
    if (most <= 0.0) { // all samples belong to other frames: the nearest one stands in
        const auto nearest = std::ranges::min_element(attachment.samples, {}, [&](int v) {
            return (part.points[v] - part.points[layout.seeds[frame]]).squaredNorm();
        });
        shares[nearest - attachment.samples.begin()] = most = 1.0;
    }
    std::vector<std::size_t> on;
    Vector3 mean = Vector3::Zero();
    double total = 0.0, nearest = std::numeric_limits<double>::infinity();
    const auto gap = [&](std::size_t i) {
        return (part.points[attachment.samples[i]] - attachment.beneath[i].point).norm();
    };
    for (std::size_t i = 0; i < count; ++i)
        if (shares[i] > 1e-3 * most) {
            on.push_back(i);
            total += shares[i];
            mean += shares[i] * (part.points[attachment.samples[i]] - part.points[0]);
            nearest = std::min(nearest, gap(i));
        }
    mean = part.points[0] + mean / total;
    double spread = 0.0;
    for (std::size_t i : on)
        spread += shares[i] / total * (part.points[attachment.samples[i]] - mean).squaredNorm();
    const double size = 2 * std::sqrt(spread), soft = nearest + size / 4 + tiny;

    Footprint footprint;
    double weights = 0.0, heaviest = 0.0;
    for (std::size_t i : on) {
        const double damping = 1 + gap(i) * gap(i) / (soft * soft);
        const double weight = shares[i] / (damping * damping);
        const double above = (gap(i) - nearest) / (size / 10 + tiny), rest = std::max(0.0, 1 - above * above);
        footprint.contacts.push_back(
            {attachment.beneath[i].point, attachment.beneath[i].triangle, weight, shares[i] * rest * rest});
        footprint.gap += weight * gap(i);
        weights += weight;
        heaviest = std::max(heaviest, weight);
    }
    footprint.gap /= weights;
    // Debris far from everything would gather large parts of the host, each piece of it again.
    const double above = std::min(nearest, std::max(2 * size, far_away * host.spacing()));
    footprint.radius = size / 2 + above + 1.5 * host.spacing();
    // Of contacts that are equal but for rounding, as midway between two limbs, that of the lowest vertex.
    int lowest = std::numeric_limits<int>::max();
    for (std::size_t k = 0; k < on.size(); ++k)
        if (footprint.contacts[k].weight > heaviest * (1 - 1e-6) && attachment.samples[on[k]] < lowest) {
            lowest = attachment.samples[on[k]];
            footprint.best = static_cast<int>(k);
        }
    return footprint;
}

/// The ways over the host between the frames of one part, infinite where they are too long for every test.
MatrixX ways_over(const HostSurface& host, const std::vector<Footprint>& footprints, double longest)
{
    const auto count = static_cast<Eigen::Index>(footprints.size());
    std::vector<int> seeds;
    for (const Footprint& footprint : footprints)
        seeds.push_back(host.triangles()[footprint.contacts[footprint.best].triangle][0]);
    MatrixX ways(count, count);
    parallel_for(
        static_cast<int>(count),
        [&](int k) {
            const std::vector<double> found = host.edges().from(seeds[k], longest);
            for (Eigen::Index u = 0; u < count; ++u)
                ways(k, u) = found[seeds[u]];
        },
        1);
    return ways;
}

/// Which frames are trusted.
std::vector<char> trusted_frames(const std::vector<Footprint>& footprints, const FrameLayout& layout,
                                 const HostSurface& host)
{
    const int count = static_cast<int>(footprints.size());
    double widest = 0.0;
    for (const Footprint& footprint : footprints)
        widest = std::max(widest, footprint.gap);
    double longest = 0.0;
    for (Eigen::Index i = 0; i < layout.distances.size(); ++i)
        if (std::isfinite(layout.distances(i)))
            longest = std::max(longest, layout.distances(i));
    const MatrixX ways = ways_over(host, footprints, 2 * longest + 2 * widest + 2 * host.spacing());
    std::vector<char> trusted(count, 1), seen(count, 0);
    using Visit = std::pair<double, int>;
    std::priority_queue<Visit, std::vector<Visit>, std::greater<>> open;
    open.emplace(0.0, static_cast<int>(std::ranges::min_element(footprints, {}, &Footprint::gap) -
                                       footprints.begin()));
    while (!open.empty()) {
        const auto [distance, k] = open.top();
        open.pop();
        if (seen[k])
            continue;
        for (int u = 0; u < count; ++u)
            if (seen[u] && trusted[u])
                trusted[k] &= static_cast<char>(ways(k, u) <= 2 * layout.distances(k, u) + footprints[k].gap +
                                                                  footprints[u].gap + 2 * host.spacing());
        seen[k] = 1;
        for (int u = 0; u < count; ++u)
            if (!seen[u] && layout.distances(k, u) < 2.2 * layout.cover)
                open.emplace(distance + layout.distances(k, u) + footprints[u].gap, u);
    }
    return trusted;
}

/// How much each frame counts, in [0, 1].
VectorX trust_of(const std::vector<Footprint>& footprints, const FrameLayout& layout, const HostSurface& host)
{
    const int count = static_cast<int>(footprints.size());
    const std::vector<char> trusted = trusted_frames(footprints, layout, host);
    const double least = std::ranges::min(footprints, {}, &Footprint::gap).gap;
    VectorX trust(count);
    for (int k = 0; k < count; ++k) {
        const double far = (footprints[k].gap - least) / (least + layout.length / 4);
        trust[k] = trusted[k] ? 1 / ((1 + far * far) * (1 + far * far)) : 0.0;
    }
    return trust;
}

MatrixX smoothing_of(VectorX trust, const FrameLayout& layout)
{
    const int count = layout.frame_count();
    trust.array() += 1e-9; // never singular
    MatrixX system = trust.asDiagonal();
    for (int k = 0; k < count; ++k)
        for (int u = 0; u < count; ++u) {
            const double ratio = layout.distances(k, u) / (2.2 * layout.cover);
            if (u == k || !(ratio < 1))
                continue;
            const double weight = smoothness * (1 - ratio * ratio) * (1 - ratio * ratio);
            system(k, k) += weight;
            system(k, u) -= weight;
        }
    MatrixX smoothing = system.partialPivLu().solve(MatrixX(trust.asDiagonal())).cwiseMax(0.0);
    const VectorX sums = smoothing.rowwise().sum();
    smoothing.array().colwise() /= sums.array();
    const Eigen::RowVectorXd together = trust.transpose() / trust.sum();
    return layout.bending * smoothing + (1 - layout.bending) * VectorX::Ones(count) * together;
}

} // namespace

AttachmentFrames make_frames(const Attachment& attachment, const Part& part, const HostSurface& host,
                             const FrameLayout& layout, double tiny)
{
    std::vector<Footprint> footprints;
    AttachmentFrames frames;
    const auto seeds = static_cast<Eigen::Index>(layout.seeds.size());
    for (int k = 0; k < seeds; ++k) {
        footprints.push_back(footprint_of(k, attachment, part, host, layout, tiny));
        const Footprint& footprint = footprints.back();
        const auto beneath = [&](int most) {
            return patch_beneath(host, footprint.contacts, footprint.best, footprint.radius, most);
        };
        frames.patches.push_back(beneath(MovingFrames::most_triangles));
        if (layout.frame_count() == 1 && host.lies_on_mirror_plane(part) &&
            reaches_mirror_plane(frames.patches.back(), host)) {
            frames.patches.back() = beneath(MovingFrames::most_triangles / 2);
            add_mirror_image(frames.patches.back(), host);
        }
        Patch& patch = frames.patches.back();
        for (std::size_t i = 0; i < patch.anchors.size(); ++i)
            patch.anchors[i] += layout.bending * (patch.weights[i] - patch.anchors[i]);
    }
    frames.smoothing = MatrixX::Ones(1, 1);
    if (layout.frame_count() > 1) {
        VectorX trust = trust_of(footprints, layout, host);
        if (!layout.images.empty()) {
            for (Eigen::Index k = 0; k < seeds; ++k)
                frames.patches.push_back(mirror_image(frames.patches[k], host));
            trust = trust.replicate(2, 1).eval();
        }
        frames.smoothing = smoothing_of(trust, layout);
        frames.feet = feet_of(part, host, layout, trust);
    }
    return frames;
}

} // namespace sinew
