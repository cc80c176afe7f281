// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/hierarchical_smoothing.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/handles/map_blend.h"
#include "native/methods/surface/linear/pyramid/coarse_motion.h"
#include "native/methods/surface/linear/pyramid/relaxed_level.h"
#include "native/operators/laplacian.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// Free vertices of the coarsest level that are enough for the shape between handles.
constexpr int enough = 64;

using Details = std::vector<std::vector<Vector3>>;

/// The workspace of a frame.
struct Workspace
{
    RelaxedLevel::Workspace level;
    Details details; ///< of the incoming shape
    Points shape, coarse_incoming, coarse;
};

/// The results of a bind.
struct Binding
{
    CoarseMotion motion;
    std::vector<int> kept; ///< the vertices of the coarsest level, ascending
    Points coarse_rest;
    std::vector<RelaxedLevel> levels;
    Details details; ///< of the rest shape
    HandleGroups groups;
    std::vector<std::vector<int>> patches;
    mutable Pool<Workspace> workspaces;
};

Points rows_of(const PointsView& points, const std::vector<int>& rows)
{
    Points some(rows.size(), 3);
    for (std::size_t k = 0; k < rows.size(); ++k)
        some.row(static_cast<Eigen::Index>(k)) = points.row(rows[k]);
    return some;
}

/// The coarsest level as a mesh of its own.
SurfaceMesh coarse_mesh(const Points& points, const std::vector<Triangle>& triangles,
                        const std::vector<int>& number)
{
    std::vector<int> corners;
    for (const Triangle& t : triangles)
        for (int v : t)
            corners.push_back(number[v]);
    return {points, std::vector<int>(triangles.size(), 3), std::move(corners)};
}

/// What a coarsest level needs to be held: the vertices that handles touch, and of each handle at least one.
std::vector<bool> touched_by(const Regions& regions)
{
    std::vector<bool> touched(regions.vertex_count(), false);
    for (const Constraint& each : regions.constraints())
        touched[each.vertex] = true;
    for (const Handle& handle : regions.handles())
        touched[handle.vertices.front()] = true;
    return touched;
}

/// The handles with the numbers of the coarsest level, and without the vertices that it lacks.
std::vector<Handle> renumbered(const std::vector<Handle>& handles, const std::vector<int>& number)
{
    std::vector<Handle> some;
    for (const Handle& handle : handles) {
        Handle& left = some.emplace_back(Handle{{}, {}, handle.continuity});
        for (std::size_t k = 0; k < handle.vertices.size(); ++k)
            if (const int v = number[handle.vertices[k]]; v >= 0) {
                left.vertices.push_back(v);
                if (!handle.weights.empty())
                    left.weights.push_back(handle.weights[k]);
            }
    }
    return some;
}

Details details_of(const std::vector<RelaxedLevel>& levels, int sweeps, Points& shape,
                   RelaxedLevel::Workspace& work)
{
    Details details(levels.size());
    for (std::size_t k = 0; k < levels.size(); ++k)
        levels[k].analyse(shape, sweeps, details[k], work);
    return details;
}

} // namespace

struct HierarchicalSmoothing::Impl
{
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

HierarchicalSmoothing::HierarchicalSmoothing(const SurfaceMesh& rest,
                                             const HierarchicalSmoothingOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
}

int HierarchicalSmoothing::level_count() const
{
    const AccessLock lock = reading();
    return static_cast<int>(impl_->bound->levels.size());
}

void HierarchicalSmoothing::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const int n = rest().vertex_count();
    const std::vector<bool> touched = touched_by(regions);
    std::vector<bool> removable(n);
    for (int v = 0; v < n; ++v)
        removable[v] = !touched[v] && regions.is_free(v);
    const ProgressiveLevels hierarchy =
        progressive_levels(rest(), std::move(removable), options().levels, enough, progress);

    std::vector<int> number(n, 0), kept;
    std::vector<RelaxedLevel> levels;
    for (const ProgressiveLevel& level : hierarchy.levels) {
        progress.tick(0.5 + 0.3 * static_cast<double>(levels.size()) /
                                static_cast<double>(hierarchy.levels.size()),
                      "computing the levels");
        for (int v : level.inserted)
            number[v] = -1;
        levels.emplace_back(rest().points(), level, touched);
    }
    HandleGroups groups(regions, connected_components(rest()));
    std::vector<int> group;
    for (int v = 0; v < n; ++v)
        if (number[v] >= 0) {
            number[v] = static_cast<int>(kept.size());
            kept.push_back(v);
            group.push_back(groups.group[v]);
        }
    Points coarse_rest = rows_of(view(rest().points()), kept), shape = rest().points();
    RelaxedLevel::Workspace work;
    Details details = details_of(levels, options().relaxations, shape, work);
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    std::size_t bytes = 0;
    for (std::size_t k = 0; k < levels.size(); ++k)
        bytes += levels[k].bytes() + details[k].size() * sizeof(Vector3);
    require_memory(static_cast<std::int64_t>(bytes), "the hierarchy");
    progress.tick(0.8, "factorising");
    try {
        bound.motion.factorize(coarse_mesh(coarse_rest, hierarchy.coarsest, number),
                               renumbered(regions.handles(), number), std::move(group),
                               [&] { progress.tick(1.0, "bound"); });
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        std::vector<int> vertices;
        for (int v : failure.elements())
            vertices.push_back(kept[v]);
        throw FactorizationFailed(failure.what(), failure.element_kind(), vertices);
    }
    report.degenerate_faces = degenerate_face_count(rest());
    bound.kept = std::move(kept);
    bound.coarse_rest = std::move(coarse_rest);
    bound.levels = std::move(levels);
    bound.details = std::move(details);
    bound.groups = std::move(groups);
    bound.patches = std::move(patches);
    bound.workspaces.clear(); // they have the size of the last level
    bound.motion.report(report);
    report.factor_bytes += static_cast<std::int64_t>(bytes);
}

SolveReport HierarchicalSmoothing::deform(const SolveRequest& /*request*/, const Targets& targets,
                                          Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const int sweeps = options().relaxations, kept = static_cast<int>(bound.kept.size());
    const auto work = bound.workspaces.take([&] {
        auto made = std::make_unique<Workspace>();
        made->details.resize(bound.levels.size());
        return made;
    });
    if (targets.incoming) {
        work->shape = *targets.incoming;
        for (std::size_t k = 0; k < bound.levels.size(); ++k)
            bound.levels[k].analyse(work->shape, sweeps, work->details[k], work->level);
        work->coarse_incoming = rows_of(*targets.incoming, bound.kept);
    }
    const Targets coarse{targets.poses, view(bound.coarse_rest),
                         targets.incoming ? std::optional(view(work->coarse_incoming)) : std::nullopt,
                         targets.from_rest};
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const HandleGroups& groups = bound.groups;
    const MapBlend blend(groups, maps);
    SolveReport report = bound.motion.move(coarse, blend, groups.count(), work->coarse);
    positions = targets.base();
    parallel_for(kept, [&](int k) { positions.row(bound.kept[k]) = work->coarse.row(k); });
    std::vector<Matrix3> turns;
    for (int g = 0; g < groups.count(); ++g)
        turns.push_back(Polar(blend.mean(g)).R);
    for (std::size_t k = 0; k < bound.levels.size(); ++k)
        bound.levels[k].synthesise(positions, sweeps, targets.incoming ? work->details[k] : bound.details[k],
                                   work->level, [&](int v) { return turns[groups.group[v]]; });
    report.half_turns = blend.half_turns(groups);
    return report;
}

void HierarchicalSmoothing::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<HierarchicalSmoothing&>(other).impl_->bound);
}

} // namespace sinew
