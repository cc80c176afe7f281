// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/space_propagation.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/straight_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>

namespace sinew {

SpacePropagation::SpacePropagation(HandlePoints handles, const SpacePropagationOptions& options)
    : SpaceMethodWith("handles"), handles_(std::move(handles)), options_(options), transfer_(options.transfer)
{
    groups_.handles.resize(static_cast<std::size_t>(handles_.handle_count()));
    std::iota(groups_.handles.begin(), groups_.handles.end(), 0);
    groups_.offsets.push_back(handles_.handle_count());
    for (int h = 0; h < handles_.handle_count(); ++h)
        means_.emplace_back(handles_.control().row(handles_.column(h)).transpose());
}

SpacePropagation::~SpacePropagation() = default;

void SpacePropagation::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    const int n = static_cast<int>(points.rows()), k = handles_.handle_count(), kept = k - 1;
    const auto size = static_cast<std::size_t>(n) * static_cast<std::size_t>(kept);
    progress.tick(0.0, "measuring distances");
    require_memory(static_cast<std::int64_t>(4 * size), "the shares of the handles");
    const double spacing = handles_.size() / std::sqrt(handles_.point_count());
    std::vector<StraightDistance> trees;
    for (int h = 0; h < k; ++h) {
        const int first = handles_.begin(h), count = handles_.count(h);
        std::vector<double> beyond;
        for (int i = first; i < first + count; ++i)
            beyond.push_back(spacing * (1.0 - handles_.weight(i)) / handles_.weight(i));
        trees.emplace_back(Points(handles_.points().middleRows(first, count)), beyond);
    }
    std::vector<float> shares(size);
    constexpr int slab = 1 << 17;
    for (int first = 0; first < n; first += slab) {
        progress.tick(static_cast<double>(first) / n, "measuring distances");
        parallel_chunks(std::min(slab, n - first), 256, [&](int begin, int end) {
            std::vector<double> away(static_cast<std::size_t>(k));
            for (int i = first + begin; i < first + end; ++i) {
                const Vector3 x = points.row(i).transpose();
                double nearest = std::numeric_limits<double>::infinity(), sum = 0.0;
                for (int h = 0; h < k; ++h)
                    nearest = std::min(nearest, away[h] = trees[h].at(x));
                for (int h = 0; h < k; ++h)
                    sum += away[h] = away[h] <= nearest ? 1.0 : nearest / away[h];
                for (int h = 0; h < kept; ++h)
                    shares[static_cast<std::size_t>(i) * kept + h] = static_cast<float>(away[h] / sum);
            }
        });
    }
    progress.tick(1.0, "measuring distances");
    report.weight_bytes = static_cast<std::int64_t>(4 * size);
    weights_ = std::move(shares);
}

double SpacePropagation::share(int point, int handle) const
{
    const int kept = handles_.handle_count() - 1;
    const float* const own = weights_.data() + static_cast<std::size_t>(point) * kept;
    if (handle < kept)
        return own[handle];
    double last = 1.0;
    for (int h = 0; h < kept; ++h)
        last -= own[h];
    return last;
}

void SpacePropagation::displace(PointsView control, PointsView base, PositionsOut out) const
{
    handles_.check(control);
    std::visit([&](auto* positions) { move(control, base, positions); }, out);
}

template <class Real>
void SpacePropagation::move(PointsView control, PointsView base, Real* out) const
{
    const int n = static_cast<int>(base.rows()), k = handles_.handle_count();
    if (control == view(handles_.control())) { // a blend would round
        std::transform(base.data(), base.data() + base.size(), out,
                       [](double x) { return static_cast<Real>(x); });
        return;
    }
    std::vector<Matrix3> maps;
    std::vector<HandleMotion> motions;
    Poses poses;
    for (int h = 0; h < k; ++h) {
        poses.push_back(handles_.map(control, h));
        maps.emplace_back(poses.back().leftCols<3>());
        motions.push_back({means_[h], apply(poses.back(), means_[h]) - means_[h],
                           (maps.back() - Matrix3::Identity()).squaredNorm()});
    }
    const PropagatedMotions blend(groups_, maps, motions);
    const PointsView rest = view(points());
    const auto held = [&](int v, Vector3& place) {
        const float* const own = weights_.data() + static_cast<std::size_t>(v) * (k - 1);
        int handle = k - 1; // if none of the others has a share
        for (int h = 0; h < k - 1; ++h)
            if (own[h] == 1.0f)
                handle = h;
            else if (own[h] != 0.0f)
                return false;
        place = apply(poses[handle], Vector3(rest.row(v).transpose()));
        return true;
    };
    parallel_chunks(n, 2048, [&](int begin, int end) {
        blend.move(
            begin, end, rest, [](int) { return 0; }, held,
            [&](int v, int count, int part_handle, double* t) {
                for (int i = 0; i < count; ++i)
                    t[i] = share(v + i, part_handle);
                transfer_.apply(t, count);
            },
            [&](int v, int count, const double* places) {
                const std::size_t first = 3 * static_cast<std::size_t>(v);
                for (int i = 0; i < 3 * count; ++i)
                    out[first + i] =
                        static_cast<Real>(base.data()[first + i] + (places[i] - rest.data()[first + i]));
            });
    });
}

std::vector<std::string> SpacePropagation::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const SpacePropagation&>(former);
    return changed(options_, other.options_, names_of({{"handles", !(handles_ == other.handles_)}}));
}

} // namespace sinew
