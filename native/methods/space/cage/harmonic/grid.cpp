// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/grid.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

namespace sinew {

namespace {

constexpr int strip = HarmonicMultigrid::strip;
constexpr double shortest = 0.05; ///< second differences over shorter links, in steps, are left out
constexpr std::int64_t interpolation_bytes = 1000; ///< about the memory per point, on all levels
constexpr int at_once = 4; ///< most strips that are solved at once
/// Several strips are solved at once only if the workspace of each is smaller than so many bytes.
constexpr std::int64_t small = 64 << 20;

} // namespace

/// The weights at a point as a combination of values at nodes and of data of the cage.
struct HarmonicGrid::Interpolation
{
    std::vector<std::pair<int, float>> nodes, data;
    double reach = 0.0; ///< largest distance of a node from the point along an axis
    void clear()
    {
        reach = 0.0;
        nodes.clear();
        data.clear();
    }
    /// Adds up the entries of a node, or of a vertex, that comes several times.
    void merge()
    {
        for (auto* list : {&nodes, &data}) {
            std::ranges::stable_sort(*list, {}, &std::pair<int, float>::first);
            std::size_t kept = 0;
            for (std::size_t k = 0; k < list->size(); ++k)
                if (kept > 0 && (*list)[kept - 1].first == (*list)[k].first)
                    (*list)[kept - 1].second += (*list)[k].second;
                else
                    (*list)[kept++] = (*list)[k];
            list->resize(kept);
        }
    }
};

/// The interpolations of many points. Those of point i begin at nodes[node_first[i]] and data[data_first[i]].
struct HarmonicGrid::Interpolations
{
    std::vector<std::size_t> node_first{0}, data_first{0};
    std::vector<std::pair<int, float>> nodes, data;
    std::vector<float> reach;
};

HarmonicGrid::HarmonicGrid(const Cage& cage, int cells)
    : columns_(cage.control_count()), lattice_(cage, cells), data_(harmonic_data(cage)),
      multigrid_(lattice_, cage, data_)
{
}

void HarmonicGrid::interpolate_in_cube(const Vector3& at, const HarmonicLattice::Node& lowest, int level,
                                       double factor, Interpolation& result) const
{
    const int width = 1 << level;
    Vector3 part;
    for (int axis = 0; axis < 3; ++axis)
        part[axis] = std::clamp((at[axis] - lowest[axis]) / width, 0.0, 1.0);
    for (int c = 0; c < 8; ++c) {
        HarmonicLattice::Node node = lowest;
        double weight = factor;
        for (int axis = 0; axis < 3; ++axis) {
            const int up = c >> axis & 1;
            node[axis] += up * width;
            weight *= up ? part[axis] : 1.0 - part[axis];
        }
        if (weight == 0.0)
            continue;
        const int row = multigrid_.row(level, node);
        if (row < 0)
            continue; // the node is in no window
        double own = weight;
        for (int axis = 0; axis < 3; ++axis) {
            const HarmonicLattice::Crossing* crossing[2];
            int neighbour[2];
            double length[2];
            bool used = true;
            for (int side = 0; side < 2; ++side) {
                HarmonicLattice::Node other = node;
                other[axis] += side ? width : -width;
                crossing[side] = lattice_.next(node, axis, side ? 1 : -1, width);
                neighbour[side] = crossing[side] ? -1 : multigrid_.row(level, other);
                length[side] = crossing[side] ? std::abs(crossing[side]->depth - node[axis]) / width : 1.0;
                used = used && (crossing[side] ? length[side] > shortest : neighbour[side] >= 0);
            }
            if (!used)
                continue;
            const double bend = -0.5 * part[axis] * (1.0 - part[axis]) * weight;
            for (int side = 0; side < 2; ++side) {
                const double share = bend * 2.0 / (length[side] * (length[0] + length[1]));
                own -= share;
                if (!crossing[side])
                    result.nodes.emplace_back(neighbour[side], static_cast<float>(share));
                else
                    data_[crossing[side]->triangle].each(crossing[side]->hats, [&](int v, double value) {
                        result.data.emplace_back(v, static_cast<float>(share * value));
                    });
            }
        }
        result.nodes.emplace_back(row, static_cast<float>(own));
    }
}

/// Interpolates at a point inside.
void HarmonicGrid::interpolate(const Vector3& at, int level, Interpolation& result) const
{
    const int width = 1 << level;
    HarmonicLattice::Node lowest;
    if (lattice_.cube(at, width, lowest) && lattice_.is_full(lowest, width)) {
        result.reach = 2.0 * width;
        interpolate_in_cube(at, lowest, level, 1.0, result);
        return;
    }
    const HarmonicLattice::Hit wall = lattice_.closest(at, width);
    if (wall.triangle < 0)
        return;
    const auto add = [&](const HarmonicLattice::Hit& hit, double factor) {
        data_[hit.triangle].each(hit.hats, [&](int v, double value) {
            result.data.emplace_back(v, static_cast<float>(factor * value));
        });
    };
    const Vector3 along = wall.distance > 1e-6 ? Vector3((at - lattice_.on(wall)) / wall.distance)
                                               : Vector3(-lattice_.normal(wall.triangle));
    const HarmonicLattice::Hit opposite = lattice_.march(at, along, width);
    const double t = wall.distance, first = t + opposite.distance; // distances from the wall
    if (opposite.triangle >= 0 || !std::isfinite(first)) {
        // Differences of Laplace's equation at the point itself, along that line and two lines across it.
        // Coarser levels use the first line alone, so that the estimate of the error shows how much the
        // others matter.
        std::array<std::pair<HarmonicLattice::Hit, Vector3>, 6> ends{{{wall, -along}, {opposite, along}}};
        const Vector3 across = along.unitOrthogonal(), third = along.cross(across);
        for (int k = 2; k < 6; ++k) {
            const Vector3 way = (k % 2 ? 1.0 : -1.0) * (k < 4 ? across : third);
            ends[k] = {lattice_.march(at, way, width), way};
        }
        std::array<double, 6> share{};
        for (int axis = 0; axis < (level == 0 ? 3 : 1); ++axis) {
            const double a = std::max(ends[2 * axis].first.distance, 1e-9),
                         b = std::max(ends[2 * axis + 1].first.distance, 1e-9);
            if (!std::isfinite(a * b))
                continue;
            share[2 * axis] = 1.0 / (a * (a + b));
            share[2 * axis + 1] = 1.0 / (b * (a + b));
        }
        const double sum = std::accumulate(share.begin(), share.end(), 0.0);
        if (!(sum > 0.0))
            return add(wall, 1.0);
        for (int k = 0; k < 6; ++k)
            if (const auto& [hit, way] = ends[k]; share[k] > 0.0 && hit.triangle >= 0) {
                add(hit, share[k] / sum);
            } else if (share[k] > 0.0) {
                result.reach = std::max(result.reach, hit.distance + 2.0 * width);
                interpolate_in_cube(at + hit.distance * way, hit.full, level, share[k] / sum, result);
            }
        return;
    }
    // The interpolation is quadratic if there is another full cube behind the first.
    const double second = first + std::max(first, static_cast<double>(width));
    const Vector3 behind = at + (second - t) * along;
    double parts[3]{1.0 - t / first, t / first, 0.0};
    if (lattice_.cube(behind, width, lowest) && lattice_.is_full(lowest, width)) {
        parts[0] = (first - t) * (second - t) / (first * second);
        parts[1] = t * (second - t) / (first * (second - first));
        parts[2] = -t * (first - t) / (second * (second - first));
        interpolate_in_cube(behind, lowest, level, parts[2], result);
    }
    result.reach = (parts[2] != 0.0 ? second : first) - t + 2.0 * width;
    add(wall, parts[0]);
    interpolate_in_cube(at + opposite.distance * along, opposite.full, level, parts[1], result);
}

HarmonicGrid::Interpolations HarmonicGrid::interpolate(PointsView points, int step, int level,
                                                       const std::vector<char>& inside) const
{
    constexpr int grain = 256;
    const int count = static_cast<int>((points.rows() + step - 1) / step);
    std::vector<Interpolations> chunks((count + grain - 1) / grain);
    parallel_chunks(count, grain, [&](int begin, int end) {
        Interpolations& own = chunks[begin / grain];
        Interpolation result;
        for (int i = begin; i < end; ++i) {
            result.clear();
            if (inside[i * step])
                interpolate(lattice_.coordinates(points.row(i * step).transpose()), level, result);
            result.merge();
            own.nodes.insert(own.nodes.end(), result.nodes.begin(), result.nodes.end());
            own.data.insert(own.data.end(), result.data.begin(), result.data.end());
            own.reach.push_back(static_cast<float>(result.reach));
            own.node_first.push_back(own.nodes.size());
            own.data_first.push_back(own.data.size());
        }
    });
    Interpolations all;
    for (const Interpolations& chunk : chunks) {
        for (std::size_t k = 1; k < chunk.node_first.size(); ++k) {
            all.node_first.push_back(all.nodes.size() + chunk.node_first[k]);
            all.data_first.push_back(all.data.size() + chunk.data_first[k]);
        }
        all.reach.insert(all.reach.end(), chunk.reach.begin(), chunk.reach.end());
        all.nodes.insert(all.nodes.end(), chunk.nodes.begin(), chunk.nodes.end());
        all.data.insert(all.data.end(), chunk.data.begin(), chunk.data.end());
    }
    return all;
}

HarmonicGrid::Weights HarmonicGrid::evaluate(PointsView points, int stride, const Progress& progress) const
{
    const int count = static_cast<int>(points.rows());
    const int strips = multigrid_.strip_count();
    const int together = multigrid_.work_bytes() < small ? std::min(at_once, strips) : 1;
    require_memory(multigrid_.bytes() + together * multigrid_.work_bytes() +
                       static_cast<std::int64_t>(count) *
                           (columns_ * static_cast<std::int64_t>(sizeof(float)) + interpolation_bytes),
                   "the lattice in the cage");
    Weights found;
    found.inside.assign(count, 0);
    parallel_for(
        count,
        [&](int i) { found.inside[i] = lattice_.holds(lattice_.coordinates(points.row(i).transpose())); },
        256);
    const int levels = multigrid_.base() + 1;
    const int checks = (count + stride - 1) / stride;
    std::vector<Interpolations> fine, coarse; // per level
    for (int level = 0; level < std::max(levels, 2); ++level) {
        fine.push_back(interpolate(points, 1, level, found.inside));
        coarse.push_back(interpolate(points, stride, level, found.inside));
    }
    std::vector<float> check(static_cast<std::size_t>(checks) * columns_, 0.0f);
    found.rows.assign(static_cast<std::size_t>(count) * columns_, 0.0f);
    /// Blends the values of a level into the rows.
    const auto gather = [&](const Interpolations& interpolations, int step, int level,
                            const std::vector<HarmonicMultigrid::Row>& values, int strip_index,
                            std::vector<float>& rows) {
        const std::span<const int> vertices = multigrid_.vertices(strip_index);
        parallel_for(
            static_cast<int>(interpolations.node_first.size()) - 1,
            [&](int i) {
                const auto share = static_cast<float>(multigrid_.share(
                    strip_index, level, lattice_.coordinates(points.row(i * step).transpose()),
                    interpolations.reach[i]));
                if (share == 0.0f)
                    return;
                HarmonicMultigrid::Row sum{};
                for (std::size_t k = interpolations.node_first[i]; k < interpolations.node_first[i + 1];
                     ++k) {
                    const auto& [row, weight] = interpolations.nodes[k];
                    for (int lane = 0; lane < strip; ++lane)
                        sum.at[lane] += weight * values[row].at[lane];
                }
                float* const row = rows.data() + static_cast<std::size_t>(i) * columns_;
                std::array<float, strip> data{};
                for (std::size_t k = interpolations.data_first[i]; k < interpolations.data_first[i + 1]; ++k)
                    if (const int place = multigrid_.place(interpolations.data[k].first);
                        place / strip == strip_index)
                        data[place % strip] += interpolations.data[k].second;
                for (std::size_t lane = 0; lane < vertices.size(); ++lane) {
                    float& weight = row[vertices[lane]];
                    weight += share * (sum.at[lane] + data[lane] - weight);
                }
            },
            1024);
    };

    std::vector<HarmonicMultigrid::Work> works(together);
    std::vector<double> residuals(strips);
    for (int first = 0; first < strips; first += together) {
        progress.tick(static_cast<double>(first) / strips, "solving the lattice");
        parallel_tasks(std::min(together, strips - first), [&](int task) {
            HarmonicMultigrid::Work& work = works[task];
            residuals[first + task] = multigrid_.solve(first + task, work, [&](int level) {
                if (level >= 1 && level < static_cast<int>(coarse.size()))
                    gather(coarse[level], stride, level, work.values[level], first + task, check);
                if (level < levels)
                    gather(fine[level], 1, level, work.values[level], first + task, found.rows);
            });
        });
    }
    found.error = *std::ranges::max_element(residuals);
    for (int i = 0; i < checks; ++i)
        for (int v = 0; v < columns_; ++v)
            found.error =
                std::max(found.error, static_cast<double>(std::abs(
                                          check[static_cast<std::size_t>(i) * columns_ + v] -
                                          found.rows[static_cast<std::size_t>(i) * stride * columns_ + v])));
    return found;
}

} // namespace sinew
