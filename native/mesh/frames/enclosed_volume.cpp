// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/enclosed_volume.h"

#include "native/core/parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr int grain = 4096; ///< triangles per chunk

/// The directed edges that have fewer neighbours than they need, turned round, with repetitions.
std::vector<std::array<int, 2>> missing_edges(const std::vector<Triangle>& triangles)
{
    std::vector<std::array<int, 3>> sides; // lower end, upper end, direction
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            if (a != b)
                sides.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    std::ranges::sort(sides);
    std::vector<std::array<int, 2>> missing;
    for (std::size_t i = 0; i < sides.size();) {
        int balance = 0;
        std::size_t j = i;
        for (; j < sides.size() && sides[j][0] == sides[i][0] && sides[j][1] == sides[i][1]; ++j)
            balance += sides[j][2];
        for (int k = 0; k < std::abs(balance); ++k)
            missing.push_back(balance > 0 ? std::array{sides[i][1], sides[i][0]}
                                          : std::array{sides[i][0], sides[i][1]});
        i = j;
    }
    return missing;
}

} // namespace

EnclosedVolume::EnclosedVolume(std::vector<Triangle> triangles, int count)
    : count_(count), triangles_(std::move(triangles))
{
    const std::vector<std::array<int, 2>> missing = missing_edges(triangles_);
    std::map<int, int> parents; // of the vertices of borders: those of one border have one root
    const auto root = [&](int v) {
        while (parents.at(v) != v)
            v = parents[v] = parents.at(parents.at(v));
        return v;
    };
    for (const auto& [a, b] : missing) {
        parents.emplace(a, a);
        parents.emplace(b, b);
        const int first = root(a), second = root(b);
        parents[std::max(first, second)] = std::min(first, second);
    }
    std::map<int, int> numbers;
    for (const auto& [v, parent] : parents) {
        const auto [at, is_new] = numbers.emplace(root(v), static_cast<int>(borders_.size()));
        if (is_new)
            borders_.emplace_back();
        borders_[at->second].push_back(v);
    }
    for (const auto& [a, b] : missing)
        fans_.push_back({a, b, count_ + numbers.at(root(a))});
}

Points EnclosedVolume::middles(const PointsView& points) const
{
    Points middles = Points::Zero(static_cast<Eigen::Index>(borders_.size()), 3);
    for (std::size_t k = 0; k < borders_.size(); ++k)
        for (const int v : borders_[k])
            middles.row(static_cast<Eigen::Index>(k)) +=
                points.row(v) / static_cast<double>(borders_[k].size());
    return middles;
}

double EnclosedVolume::share_of_fans(const PointsView& points) const
{
    const Points middle = middles(points);
    const auto area = [&](const std::vector<Triangle>& triangles) {
        double sum = 0.0;
        for (const Triangle& t : triangles) {
            const Vector3 a = corner(points, middle, t[0]);
            sum += (corner(points, middle, t[1]) - a).cross(corner(points, middle, t[2]) - a).norm();
        }
        return sum;
    };
    const double own = area(triangles_);
    return own > 0 ? area(fans_) / own : 1.0;
}

double EnclosedVolume::of(const PointsView& points) const
{
    const Points still = Points::Zero(points.rows(), 3);
    return along(points, view(still))[0];
}

double EnclosedVolume::gradient(const PointsView& points, Points& gradient) const
{
    const Points middle = middles(points);
    const Vector3 origin = points.rows() > 0 ? Vector3(points.row(0).transpose()) : Vector3::Zero();
    gradient.setZero(points.rows(), 3);
    Points of_middles = Points::Zero(middle.rows(), 3);
    double volume = 0.0;
    for (const std::vector<Triangle>* const list : {&triangles_, &fans_})
        for (const Triangle& t : *list) {
            Vector3 p[3];
            for (int k = 0; k < 3; ++k)
                p[k] = corner(points, middle, t[k]) - origin;
            volume += p[0].dot(p[1].cross(p[2]));
            for (int k = 0; k < 3; ++k) {
                const Eigen::RowVector3d part = p[(k + 1) % 3].cross(p[(k + 2) % 3]).transpose() / 6.0;
                if (t[k] < count_)
                    gradient.row(t[k]) += part;
                else
                    of_middles.row(t[k] - count_) += part;
            }
        }
    for (std::size_t k = 0; k < borders_.size(); ++k)
        for (const int v : borders_[k])
            gradient.row(v) +=
                of_middles.row(static_cast<Eigen::Index>(k)) / static_cast<double>(borders_[k].size());
    return volume / 6.0;
}

std::array<double, 4> EnclosedVolume::along(const PointsView& points, const PointsView& moves) const
{
    const Points from = middles(points), by = middles(moves);
    const Vector3 origin = points.rows() > 0 ? Vector3(points.row(0).transpose()) : Vector3::Zero();
    const auto own = static_cast<int>(triangles_.size()), all = own + static_cast<int>(fans_.size());
    std::vector<std::array<double, 4>> parts((all + grain - 1) / grain);
    parallel_chunks(all, grain, [&](int begin, int end) {
        std::array<double, 4> sums{};
        for (int i = begin; i < end; ++i) {
            const Triangle& t = i < own ? triangles_[i] : fans_[i - own];
            const Vector3 a = corner(points, from, t[0]) - origin, b = corner(points, from, t[1]) - origin,
                          c = corner(points, from, t[2]) - origin, u = corner(moves, by, t[0]),
                          v = corner(moves, by, t[1]), w = corner(moves, by, t[2]);
            const Vector3 bc = b.cross(c), vw = v.cross(w), mixed = b.cross(w) + v.cross(c);
            sums[0] += a.dot(bc);
            sums[1] += u.dot(bc) + a.dot(mixed);
            sums[2] += u.dot(mixed) + a.dot(vw);
            sums[3] += u.dot(vw);
        }
        parts[begin / grain] = sums;
    });
    std::array<double, 4> total{};
    for (const auto& part : parts)
        for (int k = 0; k < 4; ++k)
            total[k] += part[k] / 6.0;
    return total;
}

std::optional<double> EnclosedVolume::step(const PointsView& points, const PointsView& moves,
                                           double wanted) const
{
    std::array<double, 4> factors = along(points, moves);
    factors[0] -= wanted;
    const double least = 1e-14 * std::abs(wanted);
    double s = 0.0;
    for (int k = 0; k < 50; ++k) {
        const double value = factors[0] + s * (factors[1] + s * (factors[2] + s * factors[3]));
        const double slope = factors[1] + s * (2 * factors[2] + 3 * s * factors[3]);
        if (std::abs(value) <= least)
            return s;
        // Where the change is not nearly linear, no small step restores the volume.
        if (!(slope * factors[1] > 0) || std::abs(slope) < 0.25 * std::abs(factors[1]))
            return {};
        const double next = s - value / slope;
        if (next == s)
            return s;
        s = next;
    }
    const double value = factors[0] + s * (factors[1] + s * (factors[2] + s * factors[3]));
    return std::abs(value) <= 1e-9 * std::abs(wanted) ? std::optional(s) : std::nullopt;
}

} // namespace sinew
