// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/handle_fields.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/geodesic_distance.h"
#include "native/operators/laplacian.h"
#include "native/operators/straight_distance.h"

#include <algorithm>
#include <limits>
#include <memory>
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

HandleFields::HandleFields(HandleGroups groups, const Regions& regions, const ConstrainedSystem& laplacian,
                           const Progress& progress)
    : groups_(std::move(groups))
{
    allocate();
    if (shares_.cols() == 0)
        return;
    const std::vector<Constraint> constraints = regions.constraints();
    MatrixX ones = MatrixX::Zero(static_cast<Eigen::Index>(constraints.size()), shares_.cols());
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int slot =
            groups_.part_handle(constraints[row]) - groups_.offsets[groups_.group[constraints[row].vertex]];
        if (slot < ones.cols())
            ones(static_cast<Eigen::Index>(row), slot) = 1.0;
    }
    if (laplacian.iterates()) {
        // Within the tolerance, the iteration may leave [0, 1].
        shares_ = laplacian.spread(ones, progress).cwiseMax(0.0).cwiseMin(1.0);
        return;
    }
    auto L = std::make_shared<SparseMatrix>(laplacian.matrix());
    if (!make_weights_positive(*L)) {
        shares_ = laplacian.spread(ones);
        return;
    }
    ConstrainedSystem positive;
    positive.factorize(std::move(L), regions);
    shares_ = positive.spread(ones);
}

HandleFields::HandleFields(HandleGroups groups, const Regions& regions, const SurfaceMesh& mesh, Field field)
    : groups_(std::move(groups))
{
    const int n = mesh.vertex_count(), width = groups_.width();
    allocate(field == Field::geodesic ? width : 4); // with the distances, or with the places of the sources
    if (shares_.cols() == 0)
        return;
    std::vector<std::vector<GeodesicDistance::Source>> sources(groups_.part_handle_count());
    const double edge = mean_edge(mesh);
    const auto add = [&](const Constraint& at, double weight) {
        const double away = weight < 1.0 ? edge * (1.0 - weight) / std::max(weight, least_weight) : 0.0;
        sources[groups_.part_handle(at)].push_back({at.vertex, away});
    };
    for (int v = 0; v < n; ++v)
        if (regions.hard(v) >= 0)
            add({v, regions.hard(v)}, 1.0);
    for (const SoftConstraint& s : regions.soft())
        add({s.vertex, s.handle}, s.weight);
    if (field == Field::euclidean) {
        std::vector<StraightDistance> trees;
        for (const auto& each : sources)
            trees.emplace_back(mesh, each);
        share_by(regions, [&](int v, int part_handle) { return trees[part_handle].at(mesh.point(v)); });
        return;
    }
    // Parts do not reach each other, so the handles that come first in their parts are measured together.
    std::vector<std::vector<double>> distances(width);
    const GeodesicDistance along(mesh);
    parallel_tasks(width, [&](int slot) {
        std::vector<GeodesicDistance::Source> together;
        for (int g = 0; g < groups_.count(); ++g)
            if (const int part_handle = groups_.offsets[g] + slot; part_handle < groups_.offsets[g + 1])
                together.insert(together.end(), sources[part_handle].begin(), sources[part_handle].end());
        distances[slot] = along.from(together);
    });
    share_by(regions, [&](int v, int part_handle) {
        return distances[part_handle - groups_.offsets[groups_.group[v]]][v];
    });
}

void HandleFields::share_by(const Regions& regions, const std::function<double(int, int)>& distance)
{
    parallel_for(regions.vertex_count(), [&](int v) {
        const int g = groups_.group[v];
        if (g < 0)
            return;
        const int begin = groups_.offsets[g], part_handles = groups_.offsets[g + 1] - begin;
        if (const int hard = regions.hard(v); hard >= 0) {
            if (const int slot = groups_.part_handle({v, hard}) - begin; slot < part_handles - 1)
                shares_(v, slot) = 1.0;
            return;
        }
        // The inverse distances, in units of the largest one. The last of them is not kept.
        double nearest = std::numeric_limits<double>::infinity(), sum = 0.0, last = 0.0;
        const auto away = [&](int slot) -> double& {
            return slot < part_handles - 1 ? shares_(v, slot) : last;
        };
        for (int slot = 0; slot < part_handles; ++slot)
            nearest = std::min(nearest, away(slot) = distance(v, begin + slot));
        for (int slot = 0; slot < part_handles; ++slot)
            sum += away(slot) = away(slot) <= nearest ? 1.0 : nearest / away(slot);
        for (int slot = 0; slot < part_handles - 1; ++slot)
            shares_(v, slot) /= sum;
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

void HandleFields::blend(const RowMatrix& values, RowMatrix& blended) const
{
    const auto columns = values.cols();
    RowMatrix differences = values; // from the last part handle of the part
    for (int g = 0; g < groups_.count(); ++g)
        for (int part_handle = groups_.offsets[g]; part_handle < groups_.offsets[g + 1]; ++part_handle)
            differences.row(part_handle) -= values.row(groups_.offsets[g + 1] - 1);
    parallel_for(static_cast<int>(groups_.group.size()), [&](int v) {
        const int g = groups_.group[v];
        if (g < 0)
            return;
        const int begin = groups_.offsets[g], last = groups_.offsets[g + 1] - 1;
        double* own = blended.data() + columns * v;
        std::copy_n(values.data() + columns * last, columns, own);
        for (int part_handle = begin; part_handle < last; ++part_handle) {
            const double share = shares_(v, part_handle - begin);
            const double* difference = differences.data() + columns * part_handle;
            for (Eigen::Index c = 0; c < columns; ++c)
                own[c] += share * difference[c];
        }
    });
}

} // namespace sinew
