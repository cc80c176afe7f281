// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/subdivision_editing.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/handles/map_blend.h"
#include "native/mesh/components.h"
#include "native/methods/surface/linear/semi_regular/control_motion.h"
#include "native/methods/surface/linear/semi_regular/handle_band.h"
#include "native/methods/surface/linear/semi_regular/subdivided_level.h"
#include "native/operators/laplacian.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace sinew {

namespace {

/// Vertices of a control mesh that are enough for the shape between handles.
constexpr int enough = 64;

using Details = std::vector<Vector3>;

/// One level beside the finest, or the finest.
struct Level
{
    SubdividedLevel subdivided;
    Details details;        ///< of the rest shape
    std::vector<int> group; ///< of each vertex of the finer side, in the groups of the handles
};

/// The workspace of a frame.
struct Workspace
{
    struct OfLevel
    {
        SubdividedLevel::Workspace passes;
        Details details; ///< of the incoming shape
        Points incoming, moved; ///< of the coarser side
    };
    std::vector<OfLevel> levels;
    ControlMotion::Workspace control;
    HandleBand::Workspace band;
};

/// The results of a bind.
struct Binding
{
    std::vector<Level> levels; ///< the finest first
    std::vector<int> depths;   ///< of each part
    std::optional<SurfaceMesh> control;
    ControlMotion motion;
    HandleBand band;
    HandleGroups groups;
    std::vector<std::vector<int>> patches;
    int factorizations = 0, analyses = 0; ///< so far
    mutable Pool<Workspace> workspaces;
};

std::vector<int> at(const std::vector<int>& values, const std::vector<int>& kept)
{
    std::vector<int> some;
    for (int v : kept)
        some.push_back(values[v]);
    return some;
}

} // namespace

struct SubdivisionEditing::Impl
{
    explicit Impl(const SubdivisionEditingOptions& given) : options(given) {}

    const SubdivisionEditingOptions& options;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();

    /// Undoes the levels of all parts with handles, and tells which parts have none.
    void coarsen(const SurfaceMesh& rest, const Regions& regions, const Components& parts, Binding& next,
                 BindReport& report, const Progress& progress) const
    {
        const bool automatic = options.coarsening == Coarsening::automatic;
        std::vector<int> part = parts.labels, group = next.groups.group;
        std::vector<Undoing> undoing(parts.count, Undoing::unwanted);
        for (int v = 0; v < rest.vertex_count(); ++v)
            if (!regions.is_idle(v))
                undoing[part[v]] = Undoing::wanted;
        next.depths.assign(parts.count, 0);
        next.control = rest;
        std::int64_t bytes = 0;
        for (int k = 0; automatic || k < options.levels; ++k) {
            progress.tick(0.1 + 0.4 * k / (k + 1.0), "undoing the levels");
            UndoneLevel undone = undo_subdivision(*next.control, part, undoing, automatic ? enough : 1);
            if (k == 0)
                tell(parts, undoing, report);
            bool any = false;
            for (int p = 0; p < parts.count; ++p) {
                const bool done = undoing[p] == Undoing::undone;
                undoing[p] = done ? Undoing::wanted : Undoing::unwanted;
                next.depths[p] += done;
                any |= done;
            }
            if (!any)
                break;
            std::vector<int> counts = std::move(undone.counts), corners = std::move(undone.corners);
            Level& level = next.levels.emplace_back(Level{SubdividedLevel(std::move(undone)), {}, group});
            bytes += level.subdivided.bytes();
            require_memory(bytes, "the levels");
            Points points;
            SubdividedLevel::Workspace work;
            level.subdivided.analyse(view(next.control->points()), points, level.details, work);
            part = at(part, level.subdivided.kept());
            group = at(group, level.subdivided.kept());
            next.control.emplace(std::move(points), std::move(counts), std::move(corners));
        }
    }

    static void tell(const Components& parts, const std::vector<Undoing>& undoing, BindReport& report)
    {
        std::vector<int> size(parts.count, 0);
        for (int p : parts.labels)
            ++size[p];
        const auto told = [&](int p) { return undoing[p] == Undoing::irregular && size[p] > 1; };
        for (int p = 0; p < parts.count; ++p)
            report.irregular_parts += told(p);
        for (std::size_t v = 0; v < parts.labels.size(); ++v)
            if (told(parts.labels[v]))
                report.irregular_vertices.push_back(static_cast<int>(v));
    }
};

SubdivisionEditing::SubdivisionEditing(const SurfaceMesh& rest, const SubdivisionEditingOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>(this->options()))
{
}

std::vector<int> SubdivisionEditing::level_counts() const
{
    const AccessLock lock = reading();
    return impl_->bound->depths;
}

SurfaceMesh SubdivisionEditing::control_mesh() const
{
    const AccessLock lock = reading();
    return impl_->bound->control ? *impl_->bound->control : rest();
}

void SubdivisionEditing::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    auto next = std::make_unique<Binding>();
    const Components parts = connected_components(rest());
    next->groups = HandleGroups(regions, parts);
    impl_->coarsen(rest(), regions, parts, *next, report, progress);

    const std::vector<Constraint> constraints = regions.constraints();
    SparseRows smooth(static_cast<Eigen::Index>(constraints.size()), rest().vertex_count());
    std::vector<int> depths; // of each constraint
    for (std::size_t i = 0; i < constraints.size(); ++i) {
        smooth.insert(static_cast<Eigen::Index>(i), constraints[i].vertex) = 1.0;
        depths.push_back(next->depths[parts.labels[constraints[i].vertex]]);
    }
    smooth.makeCompressed();
    std::vector<int> vertex(rest().vertex_count()), group = next->groups.group;
    for (int v = 0; v < rest().vertex_count(); ++v)
        vertex[v] = v;
    for (const Level& level : next->levels) {
        smooth = SparseRows(smooth * level.subdivided.rule());
        vertex = at(vertex, level.subdivided.kept());
        group = at(group, level.subdivided.kept());
    }
    progress.tick(0.5, "factorising");
    try {
        next->motion.factorize(*next->control, std::move(smooth), regions, depths, std::move(group));
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        throw FactorizationFailed(failure.what(), failure.element_kind(), at(vertex, failure.elements()));
    }
    progress.tick(0.8, "factorising around the handles");
    std::vector<int> levels;
    for (int p : parts.labels)
        levels.push_back(next->depths[p]);
    next->band.factorize(rest(), regions, levels);
    next->patches = handle_patches(rest(), regions);
    report.degenerate_faces = degenerate_face_count(rest());

    next->factorizations = impl_->bound->factorizations;
    next->analyses = impl_->bound->analyses;
    const auto count = [&](const SpdFactor& factor) {
        next->factorizations += factor.factorizations();
        next->analyses += factor.analyses();
        report.factor_bytes += factor.bytes();
    };
    count(next->motion.factor());
    count(next->band.factor());
    for (const Level& level : next->levels) {
        count(level.subdivided.factor());
        report.factor_bytes += level.subdivided.bytes() - level.subdivided.factor().bytes();
    }
    report.factorizations = next->factorizations;
    report.analyses = next->analyses;
    report.refactored = 1.0;
    progress.tick(1.0, "bound");
    impl_->bound = std::move(next);
}

SolveReport SubdivisionEditing::deform(const SolveRequest& /*request*/, const Targets& targets,
                                       Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto work = bound.workspaces.take([&] {
        auto made = std::make_unique<Workspace>();
        made->levels.resize(bound.levels.size());
        return made;
    });
    PointsView incoming = targets.base();
    if (targets.incoming)
        for (std::size_t k = 0; k < bound.levels.size(); ++k) {
            Workspace::OfLevel& level = work->levels[k];
            bound.levels[k].subdivided.analyse(incoming, level.incoming, level.details, level.passes);
            new (&incoming) PointsView(view(level.incoming));
        }
    const Targets control{targets.poses, view(bound.control->points()),
                          targets.incoming ? std::optional(incoming) : std::nullopt, targets.from_rest};
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const MapBlend blend(bound.groups, maps);
    Points& coarsest = bound.levels.empty() ? positions : work->levels.back().moved;
    SolveReport report = bound.motion.move(control, blend, bound.groups.count(), coarsest, work->control);
    std::vector<Matrix3> turns;
    for (int g = 0; g < bound.groups.count(); ++g)
        turns.push_back(Polar(blend.mean(g)).R);
    for (std::size_t k = bound.levels.size(); k-- > 0;) {
        const Level& level = bound.levels[k];
        Workspace::OfLevel& kept = work->levels[k];
        level.subdivided.synthesise(
            kept.moved, targets.incoming ? kept.details : level.details,
            [&](int v) { return turns[level.group[v]]; }, k == 0 ? positions : work->levels[k - 1].moved,
            kept.passes);
    }
    bound.band.meet(targets, positions, work->band);
    report.half_turns = blend.half_turns(bound.groups);
    return report;
}

void SubdivisionEditing::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<SubdivisionEditing&>(other).impl_->bound);
}

} // namespace sinew
