// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/handle_band.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

constexpr int fewest_rings = 4;
constexpr int seam = 2; ///< rings around the band whose triangles the plate's equations in it need

/// Adds the neighbours of the marked vertices, face by face. Returns whether there are any.
bool widen(const SurfaceMesh& mesh, std::vector<char>& marked, const auto& may)
{
    std::vector<int> fresh;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        if (std::ranges::any_of(loop, [&](int v) { return marked[v]; }))
            for (int v : loop)
                if (!marked[v] && may(v))
                    fresh.push_back(v);
    }
    for (int v : fresh)
        marked[v] = 1;
    return !fresh.empty();
}

} // namespace

void HandleBand::factorize(const SurfaceMesh& mesh, const Regions& regions, const std::vector<int>& levels)
{
    const int n = mesh.vertex_count();
    std::vector<char> marked(n, 0);
    int rings = 0;
    for (const Constraint& each : regions.constraints())
        if (levels[each.vertex] > 0) {
            marked[each.vertex] = 1;
            rings = std::max({rings, fewest_rings, 1 << levels[each.vertex]});
            (regions.hard(each.vertex) >= 0 ? held_ : pulled_).push_back(each);
        }
    for (int ring = 0; ring < rings; ++ring)
        if (!widen(mesh, marked, [&](int v) { return ring < std::max(fewest_rings, 1 << levels[v]); }))
            break;
    std::vector<char> around(n);
    for (int v = 0; v < n; ++v)
        around[v] = marked[v] = marked[v] && regions.hard(v) < 0;
    if (std::ranges::none_of(marked, [](char in) { return in; }))
        return;
    for (int ring = 0; ring < seam; ++ring)
        widen(mesh, around, [](int) { return true; });

    std::vector<int> number(n, -1);
    for (int v = 0; v < n; ++v)
        if (around[v]) {
            number[v] = static_cast<int>(vertices_.size());
            vertices_.push_back(v);
            free_.push_back(marked[v]);
        }
    Points points(vertices_.size(), 3);
    for (std::size_t k = 0; k < vertices_.size(); ++k)
        points.row(static_cast<Eigen::Index>(k)) = mesh.points().row(vertices_[k]);
    std::vector<int> counts, corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        if (std::ranges::any_of(loop, [&](int v) { return number[v] < 0; }))
            continue;
        counts.push_back(static_cast<int>(loop.size()));
        for (int v : loop)
            corners.push_back(number[v]);
    }
    const SparseMatrix A = plate_energy({std::move(points), std::move(counts), std::move(corners)});
    for (const Constraint& each : held_)
        if (number[each.vertex] >= 0)
            ahead_.emplace_back(number[each.vertex], each);
    const VectorX diagonal = A.diagonal();
    const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
    SparseRows pulls(static_cast<Eigen::Index>(pulled_.size()), A.cols());
    std::vector<double> stiffness;
    std::size_t row = 0;
    for (const SoftConstraint& soft : regions.soft()) {
        if (levels[soft.vertex] == 0)
            continue;
        const int k = number[soft.vertex];
        pulls.insert(static_cast<Eigen::Index>(row++), k) = 1.0;
        stiffness.push_back(soft.stiffness() * (diagonal[k] > 0 ? diagonal[k] : mean));
    }
    pulls.makeCompressed();
    try {
        system_.factorize(A, pulls, std::move(stiffness), free_);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        std::vector<int> vertices;
        for (int k : failure.elements())
            vertices.push_back(vertices_[k]);
        throw FactorizationFailed(failure.what(), failure.element_kind(), vertices);
    }
}

void HandleBand::meet(const Targets& targets, Points& positions, Workspace& work) const
{
    const auto left = [&](const Constraint& each) -> Eigen::RowVector3d {
        return targets.position(each.vertex, each.handle).transpose() - positions.row(each.vertex);
    };
    if (!system_.is_empty()) {
        work.u.setZero(static_cast<Eigen::Index>(vertices_.size()), 3);
        for (const auto& [k, each] : ahead_)
            work.u.row(k) = left(each);
        work.pulled.resize(static_cast<Eigen::Index>(pulled_.size()), 3);
        for (std::size_t k = 0; k < pulled_.size(); ++k)
            work.pulled.row(static_cast<Eigen::Index>(k)) = left(pulled_[k]);
        system_.solve(work.u, work.pulled, work.system);
        parallel_for(static_cast<int>(vertices_.size()), [&](int k) {
            if (free_[k])
                positions.row(vertices_[k]) += work.u.row(k);
        });
    }
    for (const Constraint& each : held_)
        positions.row(each.vertex) = targets.position(each.vertex, each.handle).transpose();
}

} // namespace sinew
