// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/propagation.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/handles/constrained_system.h"
#include "native/handles/map_blend.h"
#include "native/handles/propagated_motions.h"
#include "native/operators/laplacian.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system; ///< of the Laplacian, for harmonic fields
    HandleFields fields;
    std::vector<Constraint> constraints;
    std::vector<int> held; ///< (n) the handle that holds each vertex, or -1
    std::vector<std::vector<int>> patches;

    std::vector<HandleMotion> motions(const Targets& targets, const std::vector<Matrix3>& maps) const;
};

std::vector<HandleMotion> Binding::motions(const Targets& targets, const std::vector<Matrix3>& maps) const
{
    std::vector<HandleMotion> motions(targets.poses.size());
    std::vector<int> counts(motions.size(), 0);
    const PointsView base = targets.base();
    for (const auto& [vertex, handle] : constraints) {
        const Vector3 y = base.row(vertex).transpose();
        motions[handle].centre += y;
        motions[handle].move += targets.position(vertex, handle) - y;
        ++counts[handle];
    }
    for (std::size_t h = 0; h < motions.size(); ++h) {
        motions[h].centre /= std::max(1, counts[h]);
        motions[h].move /= std::max(1, counts[h]);
        motions[h].turning = (maps[h] - Matrix3::Identity()).squaredNorm();
    }
    return motions;
}

} // namespace

struct Propagation::Impl
{
    TransferCurve transfer;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

Propagation::Propagation(const SurfaceMesh& rest, const PropagationOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    impl_->transfer = TransferCurve(options.transfer);
}

void Propagation::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    HandleGroups groups(regions, connected_components(rest()));
    std::vector<Constraint> constraints = regions.constraints();
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    std::vector<int> held(rest().vertex_count());
    for (int v = 0; v < rest().vertex_count(); ++v)
        held[v] = regions.hard(v);
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    HandleFields fields;
    if (options().field == Field::harmonic) {
        auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), Discretization::cotan, metric));
        make_weights_positive(*L);
        progress.tick(0.2, "factorising");
        bound.system.factorize(std::move(L), regions, [&] {
            progress.tick(0.7, "computing the fields");
            fields = HandleFields(std::move(groups), regions, bound.system);
            progress.tick(1.0, "bound");
        });
    } else {
        progress.tick(0.2, "measuring distances");
        fields = HandleFields(std::move(groups), regions, rest(), options().field);
        progress.tick(1.0, "bound");
    }
    bound.fields = std::move(fields);
    bound.constraints = std::move(constraints);
    bound.held = std::move(held);
    bound.patches = std::move(patches);
    bound.system.report(report);
}

SolveReport Propagation::deform(const SolveRequest& /*request*/, const Targets& targets,
                                Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const HandleGroups& groups = bound.fields.groups();
    const PropagatedMotions motions(groups, maps, bound.motions(targets, maps));
    const PointsView base = targets.base();
    const int n = static_cast<int>(base.rows());
    positions.resize(n, 3);
    const auto shares = [&](int v, int count, int part_handle, double* t) {
        bound.fields.shares(v, count, part_handle, t);
        impl_->transfer.apply(t, count);
    };
    const auto held = [&](int v, Vector3& place) {
        if (groups.group[v] >= 0 && bound.held[v] >= 0)
            place = targets.position(v, bound.held[v]);
        return groups.group[v] >= 0 && bound.held[v] >= 0;
    };
    parallel_chunks(n, 2048, [&](int begin, int end) {
        motions.move(
            begin, end, base, [&](int v) { return groups.group[v]; }, held, shares,
            [&](int v, int count, const double* places) {
                std::copy_n(places, 3 * count, positions.data() + 3 * static_cast<std::size_t>(v));
            });
    });
    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.half_turns = motions.half_turns(groups);
    return report;
}

void Propagation::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<Propagation&>(other).impl_->bound);
}

} // namespace sinew
