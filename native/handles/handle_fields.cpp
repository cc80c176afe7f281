// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/handle_fields.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/geodesic_distance.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double least_weight = 1e-12; ///< below this, a soft vertex does not get farther away

double mean_edge(const SurfaceMesh& mesh)
{
    double sum = 0.0;
    const auto edges = mesh.edges();
    for (const auto& [a, b] : edges)
        sum += (mesh.point(a) - mesh.point(b)).norm();
    return edges.empty() ? 0.0 : sum / static_cast<double>(edges.size());
}

} // namespace

HandleFields::HandleFields(HandleGroups groups, const Regions& regions, const HeldSystem& laplacian)
    : groups_(std::move(groups))
{
    allocate();
    if (shares_.cols() == 0)
        return;
    const std::vector<Constraint> constraints = regions.constraints();
    MatrixX ones = MatrixX::Zero(static_cast<Eigen::Index>(constraints.size()), shares_.cols());
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int slot =
            groups_.seat(constraints[row]) - groups_.offsets[groups_.group[constraints[row].vertex]];
        if (slot < ones.cols())
            ones(static_cast<Eigen::Index>(row), slot) = 1.0;
    }
    shares_ = laplacian.spread(ones);
}

HandleFields::HandleFields(HandleGroups groups, const Regions& regions, const SurfaceMesh& mesh)
    : groups_(std::move(groups))
{
    const int n = mesh.vertex_count(), width = groups_.width();
    allocate(width); // with the distances from the handles
    if (shares_.cols() == 0)
        return;
    // Parts do not reach each other, so the handles that come first in their parts are measured together.
    std::vector<std::vector<GeodesicDistance::Source>> sources(width);
    const double edge = mean_edge(mesh);
    const auto add = [&](const Constraint& at, double weight) {
        const double away = weight < 1.0 ? edge * (1.0 - weight) / std::max(weight, least_weight) : 0.0;
        sources[groups_.seat(at) - groups_.offsets[groups_.group[at.vertex]]].push_back({at.vertex, away});
    };
    for (int v = 0; v < n; ++v)
        if (regions.hard(v) >= 0)
            add({v, regions.hard(v)}, 1.0);
    for (const SoftConstraint& s : regions.soft())
        add({s.vertex, s.handle}, s.weight);
    std::vector<std::vector<double>> distances(width);
    const GeodesicDistance along(mesh);
    parallel_tasks(width, [&](int slot) { distances[slot] = along.from(sources[slot]); });

    parallel_for(n, [&](int v) {
        const int g = groups_.group[v];
        if (g < 0)
            return;
        const int seats = groups_.offsets[g + 1] - groups_.offsets[g];
        double nearest = distances[0][v];
        for (int slot = 1; slot < seats; ++slot)
            nearest = std::min(nearest, distances[slot][v]);
        const auto closeness = [&](int slot) {
            if (regions.hard(v) >= 0)
                return groups_.handles[groups_.offsets[g] + slot] == regions.hard(v) ? 1.0 : 0.0;
            const double distance = distances[slot][v];
            return distance <= nearest ? 1.0 : nearest / distance;
        };
        double sum = 0.0;
        for (int slot = 0; slot < seats; ++slot)
            sum += closeness(slot);
        for (int slot = 0; slot < seats - 1; ++slot)
            shares_(v, slot) = closeness(slot) / sum;
    });
}

void HandleFields::allocate(int columns_beside)
{
    const auto n = static_cast<Eigen::Index>(groups_.group.size());
    const Eigen::Index columns = std::max(0, groups_.width() - 1);
    require_memory(static_cast<std::int64_t>(sizeof(double)) * n * (columns + columns_beside),
                   "the fields of the handles");
    shares_ = RowMatrix::Zero(n, columns);
}

double HandleFields::share(int vertex, int seat) const
{
    const int g = groups_.group[vertex], begin = groups_.offsets[g],
              last = groups_.offsets[g + 1] - 1 - begin;
    if (seat - begin < last)
        return shares_(vertex, seat - begin);
    double share = 1.0;
    for (int slot = 0; slot < last; ++slot)
        share -= shares_(vertex, slot);
    return share;
}

void HandleFields::blend(const RowMatrix& values, RowMatrix& blended) const
{
    const auto columns = values.cols();
    RowMatrix differences = values; // from the last seat of the part
    for (int g = 0; g < groups_.count(); ++g)
        for (int seat = groups_.offsets[g]; seat < groups_.offsets[g + 1]; ++seat)
            differences.row(seat) -= values.row(groups_.offsets[g + 1] - 1);
    parallel_for(static_cast<int>(groups_.group.size()), [&](int v) {
        const int g = groups_.group[v];
        if (g < 0)
            return;
        const int begin = groups_.offsets[g], last = groups_.offsets[g + 1] - 1;
        double* own = blended.data() + columns * v;
        std::copy_n(values.data() + columns * last, columns, own);
        for (int seat = begin; seat < last; ++seat) {
            const double share = shares_(v, seat - begin);
            const double* difference = differences.data() + columns * seat;
            for (Eigen::Index c = 0; c < columns; ++c)
                own[c] += share * difference[c];
        }
    });
}

} // namespace sinew
