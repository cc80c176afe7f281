// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/frame_layout.h"

#include "native/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace sinew {

namespace {

constexpr int most_inside_samples = 256;

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
    const EdgeDistances edges(part.points, part.ways());
    std::vector<std::vector<double>> ways{edges.from(layout.seeds[0])};
    std::vector<double> nearest = ways[0];
    double first_radius = 0.0;
    for (;;) {
        int farthest = -1;
        layout.cover = 0.0;
        for (int v = 0; v < static_cast<int>(n); ++v)
            if (std::isfinite(nearest[v]) && nearest[v] > layout.cover) {
                layout.cover = nearest[v];
                farthest = v;
            }
        if (ways.size() == 1)
            first_radius = layout.cover;
        if (layout.cover <= layout.length || layout.frame_count() == most_frames)
            break;
        layout.seeds.push_back(farthest);
        ways.push_back(edges.from(farthest));
        for (Eigen::Index v = 0; v < n; ++v)
            nearest[v] = std::min(nearest[v], ways.back()[v]);
    }
    layout.cover = std::max(layout.cover, layout.length);
    layout.bending = (1 - stiffness) * smoothstep(first_radius / layout.length - 1);
    layout.shares.resize(layout.frame_count(), n);
    layout.distances.resize(layout.frame_count(), layout.frame_count());
    for (int k = 0; k < layout.frame_count(); ++k) {
        for (Eigen::Index v = 0; v < n; ++v)
            layout.shares(k, v) = kernel(ways[k][v], 2 * layout.cover);
        for (int other = 0; other < layout.frame_count(); ++other)
            layout.distances(k, other) = ways[k][layout.seeds[other]];
    }
    limit_and_normalise(layout.shares);
    return layout;
}

} // namespace sinew
