// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/pyramid/relaxed_level.h"

#include "native/core/parallel.h"
#include "native/methods/surface/linear/pyramid/second_differences.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <utility>

namespace sinew {

namespace {

/// Second differences are at most four times as large as their diagonal, so that half a step always
/// converges.
constexpr double step = 0.5;

/// Entries of a list per vertex, in the order in which they are counted.
struct Lists
{
    std::vector<int> offsets, entries;

    std::span<const int> at(int v) const
    {
        return {entries.data() + offsets[v], entries.data() + offsets[v + 1]};
    }
};

template <class Elements, class Vertices>
Lists lists_of(std::size_t n, const Elements& elements, const Vertices& vertices)
{
    Lists lists;
    lists.offsets.assign(n + 1, 0);
    for (const auto& element : elements)
        for (int v : vertices(element))
            ++lists.offsets[v + 1];
    for (std::size_t v = 0; v < n; ++v)
        lists.offsets[v + 1] += lists.offsets[v];
    lists.entries.resize(lists.offsets.back());
    std::vector<int> next(lists.offsets.begin(), lists.offsets.end() - 1);
    for (std::size_t k = 0; k < elements.size(); ++k)
        for (int v : vertices(elements[k]))
            lists.entries[next[v]++] = static_cast<int>(k);
    return lists;
}

} // namespace

RelaxedLevel::RelaxedLevel(const Points& rest, const ProgressiveLevel& level,
                           const std::vector<bool>& touched)
    : inserted_(level.inserted)
{
    const auto n = static_cast<std::size_t>(rest.rows());
    const std::vector<SecondDifference> differences = second_differences(rest, level.triangles);
    const Lists differences_at =
        lists_of(n, differences, [](const SecondDifference& d) -> const auto& { return d.vertices; });
    const Lists triangles_at =
        lists_of(n, level.triangles, [](const Triangle& t) -> const auto& { return t; });
    std::vector<bool> fresh(n, false), near(n, false);
    for (int v : inserted_) {
        fresh[v] = near[v] = true;
        for (int t : triangles_at.at(v))
            for (int other : level.triangles[t])
                near[other] = true;
    }

    std::vector<std::pair<int, double>> row;
    // The row of v from the second differences that have no other vertex for which `unknown` holds.
    const auto add_row = [&](int v, const std::vector<bool>* unknown, Stencils& to) {
        row.clear();
        double own = 0.0;
        for (int e : differences_at.at(v)) {
            const auto& [vertices, weights] = differences[e];
            const bool usable = !unknown || std::ranges::all_of(vertices, [&](int other) {
                return other == v || !(*unknown)[other];
            });
            if (!usable)
                continue;
            const double mine = weights[std::ranges::find(vertices, v) - vertices.begin()];
            own += mine * mine;
            for (int k = 0; k < 4; ++k)
                if (vertices[k] != v)
                    row.emplace_back(vertices[k], -mine * weights[k]);
        }
        if (!(own > 0)) {
            row.clear();
            return false;
        }
        std::ranges::sort(row);
        for (std::size_t k = 0; k < row.size(); ++k)
            if (k > 0 && row[k].first == row[k - 1].first) {
                to.weights.back() += row[k].second / own;
            } else {
                to.vertices.push_back(row[k].first);
                to.weights.push_back(row[k].second / own);
            }
        to.offsets.push_back(static_cast<int>(to.vertices.size()));
        return true;
    };
    std::vector<int> around;
    const auto ring_of = [&](int v) {
        around.clear();
        for (int t : triangles_at.at(v))
            for (int other : level.triangles[t])
                if (other != v)
                    around.push_back(other);
        std::ranges::sort(around);
        around.erase(std::unique(around.begin(), around.end()), around.end());
    };

    for (int v : inserted_)
        if (!add_row(v, &fresh, predictions_)) {
            ring_of(v);
            for (int other : around) {
                predictions_.vertices.push_back(other);
                predictions_.weights.push_back(1.0 / static_cast<double>(around.size()));
            }
            predictions_.offsets.push_back(static_cast<int>(predictions_.vertices.size()));
        }
    for (int v = 0; v < static_cast<int>(n); ++v) {
        if (!near[v] || touched[v] || triangles_at.at(v).empty())
            continue;
        if (!add_row(v, nullptr, relaxations_)) {
            if (!fresh[v])
                continue;
            relaxations_.vertices.push_back(v); // it stays where it is predicted
            relaxations_.weights.push_back(1.0);
            relaxations_.offsets.push_back(static_cast<int>(relaxations_.vertices.size()));
        }
        Vector3 normal = Vector3::Zero();
        for (int t : triangles_at.at(v)) {
            const auto [a, b, c] = level.triangles[t];
            normal += Vector3(rest.row(b) - rest.row(a)).cross(Vector3(rest.row(c) - rest.row(a)));
        }
        ring_of(v);
        moving_.push_back(v);
        frames_.add(fitted_tangents(rest, v, around, normal));
    }
}

void RelaxedLevel::relax(Points& x, int sweeps, Workspace& work) const
{
    parallel_for(static_cast<int>(inserted_.size()),
                 [&](int k) { x.row(inserted_[k]) = predictions_.at(k, x).transpose(); });
    const int count = static_cast<int>(moving_.size());
    work.moved.resize(moving_.size());
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        parallel_for(count, [&](int k) {
            const Vector3 own = x.row(moving_[k]).transpose();
            work.moved[k] = own + step * (relaxations_.at(k, x) - own);
        });
        put(work, x);
    }
}

void RelaxedLevel::put(const Workspace& work, Points& x) const
{
    parallel_for(static_cast<int>(moving_.size()),
                 [&](int k) { x.row(moving_[k]) = work.moved[k].transpose(); });
}

void RelaxedLevel::analyse(Points& y, int sweeps, std::vector<Vector3>& details, Workspace& work) const
{
    const int count = static_cast<int>(moving_.size());
    details.resize(moving_.size());
    for (int k = 0; k < count; ++k)
        details[k] = y.row(moving_[k]).transpose();
    relax(y, sweeps, work);
    work.moved = details;
    parallel_for(count, [&](int k) {
        const int v = moving_[k];
        const Matrix3 frame = frames_.at(k, v, y, Matrix3::Identity());
        details[k] = frame.transpose() * (work.moved[k] - y.row(v).transpose());
    });
    put(work, y);
}

void RelaxedLevel::synthesise(Points& x, int sweeps, const std::vector<Vector3>& details, Workspace& work,
                              const std::function<Matrix3(int vertex)>& fallback) const
{
    relax(x, sweeps, work);
    parallel_for(static_cast<int>(moving_.size()), [&](int k) {
        const int v = moving_[k];
        work.moved[k] = x.row(v).transpose() + frames_.at(k, v, x, fallback(v)) * details[k];
    });
    put(work, x);
}

std::size_t RelaxedLevel::bytes() const
{
    std::size_t bytes = frames_.bytes() + (inserted_.size() + moving_.size()) * sizeof(int);
    for (const Stencils& each : {std::cref(predictions_), std::cref(relaxations_)})
        bytes += each.vertices.size() * (sizeof(int) + sizeof(double)) + each.offsets.size() * sizeof(int);
    return bytes;
}

} // namespace sinew
