// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/frame_layout.h"

#include "native/mesh/trees/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace sinew {

namespace {

constexpr int most_inside_samples = 256;
constexpr double tie = 1e-9; ///< of a length: what differs less is equal, and the lower vertex counts

/// Whether a part is worn by its host: whether the host's area inside the part is above half the part's own.
bool wraps(const Part& part, const ClosedPart& closed, const HostSurface& host)
{
    std::vector<int> within;
    double total = 0.0;
    for (int t = 0; t < static_cast<int>(host.centres().size()); ++t)
        if (part.box.contains(host.centres()[t])) {
            within.push_back(t);
            total += host.areas()[t];
        }
    if (within.empty())
        return false;
    const TriangleTree tree(closed.points, closed.triangles);
    const Vector3 direction(0.5357, 0.6301, 0.5622); // along no axis, so that it rarely meets an edge
    const std::size_t step = std::max<std::size_t>(1, within.size() / most_inside_samples);
    double sampled = 0.0, inside = 0.0;
    for (std::size_t i = 0; i < within.size(); i += step) {
        const double area = host.areas()[within[i]];
        sampled += area;
        inside += tree.crossings(host.centres()[within[i]], direction) != 0 ? area : 0.0;
    }
    return total * inside / sampled > 0.5 * part.area;
}

double bend_length(const Part& part, const HostSurface& host, double length)
{
    if (part.extent() <= length || part.triangles.empty())
        return length;
    const ClosedPart closed(part);
    const double thick = 2 * closed.thickness();
    return thick > length && !wraps(part, closed, host) ? thick : length;
}

double smoothstep(double x)
{
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// (1 - (distance / radius)^2)^2, and 0 beyond.
double kernel(double distance, double radius)
{
    const double rest = std::max(0.0, 1 - distance * distance / (radius * radius));
    return rest * rest;
}

/// Leaves at most four shares of each vertex, continuously, and normalises them.
void limit_and_normalise(MatrixX& shares)
{
    std::vector<double> sorted(shares.rows());
    for (Eigen::Index v = 0; v < shares.cols(); ++v) {
        auto column = shares.col(v);
        if (column.size() > 4) {
            std::copy(column.begin(), column.end(), sorted.begin());
            std::ranges::nth_element(sorted, sorted.begin() + 4, std::greater());
            column = (column.array() - sorted[4]).max(0.0).matrix();
        }
        if (const double sum = column.sum(); sum > 0.0)
            column /= sum;
        else
            column[0] = 1.0; // no edge leads there
    }
}

/// Where the mirror images of a part's vertices are on it; empty if it is no image of itself, does not lie on
/// the mirror plane of its host, or lies where the host is far from the plane, as between two limbs.
std::vector<TriangleTree::Place> mirror_images(const Part& part, const HostSurface& host)
{
    constexpr double tolerance = 1e-2;
    if (!host.lies_on_mirror_plane(part))
        return {};
    int on_plane = 0, over_plane = 0;
    for (const Vector3& point : part.points)
        if ((host.mirror_image(point) - point).norm() <= tolerance * part.extent()) {
            ++on_plane;
            over_plane += host.is_near_mirror_plane(host.tree().closest(point)) ? 1 : 0;
        }
    const TriangleTree tree(part.points, part.triangles);
    if (2 * over_plane < on_plane || tree.empty())
        return {};
    std::vector<TriangleTree::Place> places;
    for (const Vector3& point : part.points) {
        const Vector3 image = host.mirror_image(point);
        places.push_back(tree.closest_place(image));
        if ((places.back().point - image).norm() > tolerance * part.extent())
            return {};
    }
    return places;
}

/// Gives each frame of a layout an image. \param ways  from each seed to each vertex.
void add_mirror_images(FrameLayout& layout, const Part& part, const std::vector<std::vector<double>>& ways)
{
    const auto count = static_cast<Eigen::Index>(layout.seeds.size());
    const MatrixX own = layout.shares / 2, distances = layout.distances;
    layout.shares.resize(2 * count, own.cols());
    layout.shares.topRows(count) = own;
    for (Eigen::Index v = 0; v < own.cols(); ++v) {
        const TriangleTree::Place& image = layout.images[v];
        const Triangle& corners = part.triangles[image.triangle];
        const Vector3 parts = barycentric(corners_of(part.points, corners), image.point);
        layout.shares.col(v).tail(count) =
            parts[0] * own.col(corners[0]) + parts[1] * own.col(corners[1]) + parts[2] * own.col(corners[2]);
    }
    MatrixX across(count, count); // from a frame to the image of another one
    for (Eigen::Index u = 0; u < count; ++u) {
        const TriangleTree::Place& image = layout.images[layout.seeds[u]];
        const int nearest = *std::ranges::min_element(part.triangles[image.triangle], {}, [&](int v) {
            return (part.points[v] - image.point).squaredNorm();
        });
        for (Eigen::Index k = 0; k < count; ++k)
            across(k, u) = ways[k][nearest];
    }
    across = (across + across.transpose()).eval() / 2;
    layout.distances.resize(2 * count, 2 * count);
    layout.distances << distances, across, across, distances;
}

} // namespace

FrameLayout lay_out_frames(const Part& part, const HostSurface& host, double length, double stiffness)
{
    FrameLayout layout;
    layout.seeds = {part.centre()};
    layout.length = bend_length(part, host, length);
    const auto n = static_cast<Eigen::Index>(part.points.size());
    if (part.extent() <= layout.length) {
        layout.cover = layout.length;
        layout.shares = MatrixX::Ones(1, n);
        layout.distances = MatrixX::Zero(1, 1);
        return layout;
    }
    layout.images = mirror_images(part, host);
    const auto most_seeds = static_cast<std::size_t>(layout.images.empty() ? most_frames : most_frames / 2);
    const EdgeDistances edges(part.points, part.ways());
    std::vector<std::vector<double>> ways{edges.from(layout.seeds[0])};
    std::vector<double> nearest = ways[0];
    double first_radius = 0.0;
    for (;;) {
        int farthest = -1;
        layout.cover = 0.0;
        for (int v = 0; v < static_cast<int>(n); ++v)
            if (std::isfinite(nearest[v]) && nearest[v] > layout.cover * (1 + tie)) {
                layout.cover = nearest[v];
                farthest = v;
            }
        if (ways.size() == 1)
            first_radius = layout.cover;
        if (layout.cover <= layout.length || layout.seeds.size() == most_seeds)
            break;
        layout.seeds.push_back(farthest);
        ways.push_back(edges.from(farthest));
        for (Eigen::Index v = 0; v < n; ++v)
            nearest[v] = std::min(nearest[v], ways.back()[v]);
    }
    layout.cover = std::max(layout.cover, layout.length);
    layout.bending = (1 - stiffness) * smoothstep(first_radius / layout.length - 1);
    const auto count = static_cast<Eigen::Index>(layout.seeds.size());
    layout.shares.resize(count, n);
    layout.distances.resize(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        for (Eigen::Index v = 0; v < n; ++v)
            layout.shares(k, v) = kernel(ways[k][v], 2 * layout.cover);
        for (Eigen::Index other = 0; other < count; ++other)
            layout.distances(k, other) = ways[k][layout.seeds[other]];
    }
    limit_and_normalise(layout.shares);
    if (count == 1) // its patch is its own image (attachment_frames.cpp)
        layout.images.clear();
    else if (!layout.images.empty())
        add_mirror_images(layout, part, ways);
    return layout;
}

} // namespace sinew
