// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramid_coordinates.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/coarse_start.h"
#include "native/local_global/rows/goals.h"
#include "native/mesh/components.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/same_faces.h"
#include "native/methods/surface/nonlinear/pyramids/morph.h"
#include "native/methods/surface/nonlinear/pyramids/problem.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

namespace sinew {

namespace {

/// An energy below this share of that of a shape shrunk to a point is rounding. Without this floor, rigid
/// poses would iterate on it.
constexpr double rounding_floor = 1e-14;
/// Where the surface hardly stretches, the metric is far stiffer than the energy, so a step may be too long.
constexpr int plain_steps = 4;

/// What does not depend on handles.
struct Assembly
{
    Rings rings;
    Rings::Weights weights;
    PyramidStiffness stiffness;
    std::optional<PyramidMorph> morph;

    Assembly(const SurfaceMesh& mesh, double side, const SurfaceMesh* target, double unit)
        : rings(mesh), weights(rings.mean_value_weights(view(mesh.points()))),
          stiffness(mesh, rings, weights, side)
    {
        if (target)
            morph.emplace(rings, weights.shares, target->points() / unit);
    }
};

/// The workspace of a solve.
struct Workspace
{
    TargetsInUnit targets;
    Goals goals;
    CoarseStart::Workspace cascade;
    std::vector<Eigen::Quaterniond> rotations, turns;
    PyramidShape shape;
    PyramidBuffers buffers;
    LbfgsWorkspace descent;
    Points x;
};

/// The results of a bind.
struct Binding
{
    const double unit;
    Points rest; ///< (n, 3) in units
    /// The vertices of each part without a handle, if these are morphed; else there is none.
    std::vector<std::vector<int>> idle_parts;
    PyramidCells cells;
    CoarseStart start;
    PyramidShape shape; ///< of the rest points
    mutable Pool<Workspace> workspaces;

    Binding(const Assembly& mesh, const SurfaceMesh& scaled, double unit, const Regions& regions,
            const Progress& progress)
        : unit(unit), rest(scaled.points()), idle_parts(parts_to_morph(mesh, scaled, regions)),
          cells(mesh.rings, mesh.weights.shares, mesh.stiffness, moving(regions), regions.soft()),
          start(scaled, regions, mesh.stiffness.smoothing, {}, progress)
    {
        cells.keep(view(rest), shape);
    }

private:
    static std::vector<std::vector<int>> parts_to_morph(const Assembly& mesh, const SurfaceMesh& scaled,
                                                        const Regions& regions)
    {
        if (!mesh.morph)
            return {};
        const Components parts = connected_components(scaled);
        std::vector<std::vector<int>> found(parts.count);
        for (int v = 0; v < scaled.vertex_count(); ++v)
            if (regions.is_idle(v))
                found[parts.labels[v]].push_back(v);
        std::erase_if(found, [](const std::vector<int>& part) { return part.empty(); });
        return found;
    }

    /// One vertex of each part without a handle stays, so that the system has one solution.
    std::vector<bool> moving(const Regions& regions) const
    {
        std::vector<bool> all(regions.vertex_count());
        for (int v = 0; v < regions.vertex_count(); ++v)
            all[v] = regions.is_free(v);
        for (const std::vector<int>& part : idle_parts)
            for (std::size_t k = 1; k < part.size(); ++k)
                all[part[k]] = true;
        return all;
    }
};

/// The goals of a morph: each handle, and each part without one, is on its way between the shape that it
/// would have without the morph and the target shape, which what enters takes along.
void morph_goals(const Binding& bound, const Regions& regions, const Targets& targets, const Points& target,
                 double t, Goals& goals)
{
    const PointsView rest = targets.rest;
    Points carried = target;
    const auto region = [&](const std::vector<int>& vertices, const PointsView& base) {
        if (base.data() != rest.data()) {
            const RigidFit motion(vertices, rest, base);
            for (const int v : vertices)
                carried.row(v) = motion(target.row(v).transpose()).transpose();
        } else {
            for (const int v : vertices)
                carried.row(v) = target.row(v);
        }
        return RegionMorph(vertices, base, view(carried), t);
    };
    for (int h = 0; h < regions.handle_count(); ++h) {
        const std::vector<int>& vertices = regions.handles()[h].vertices;
        const PointsView base = targets.from_rest && (*targets.from_rest)[h] ? targets.rest : targets.base();
        const RegionMorph morph = region(vertices, base);
        const auto goal = [&](int v) {
            return apply(targets.poses[h], morph.at(base.row(v).transpose(), carried.row(v).transpose()));
        };
        for (const int v : vertices)
            if (regions.hard(v) == h)
                goals.held.row(v) = goal(v).transpose();
        for (std::size_t k = 0; k < regions.soft().size(); ++k)
            if (regions.soft()[k].handle == h)
                goals.pulls.row(static_cast<Eigen::Index>(k)) = goal(regions.soft()[k].vertex).transpose();
    }
    for (const std::vector<int>& part : bound.idle_parts) {
        const RegionMorph morph = region(part, targets.base());
        for (const int v : part)
            goals.held.row(v) =
                morph.at(targets.base().row(v).transpose(), carried.row(v).transpose()).transpose();
    }
}

/// The mean size to which the handles scale.
double scale_of(const Poses& poses)
{
    double sum = 0.0;
    int count = 0;
    for (const Pose& pose : poses)
        if (const double volume = std::abs(pose.leftCols<3>().determinant()); volume > 0) {
            sum += std::log(volume) / 3.0;
            ++count;
        }
    return std::clamp(count > 0 ? std::exp(sum / count) : 1.0, PyramidProblem::least_scale,
                      PyramidProblem::most_scale);
}

} // namespace

struct PyramidCoordinates::Impl
{
    double unit = 1.0; ///< see normal_unit()
    std::optional<Assembly> assembled; ///< by the first bind
    int factorizations = 0;
    std::unique_ptr<const Binding> bound; ///< null before the first bind
};

PyramidCoordinates::PyramidCoordinates(const SurfaceMesh& rest, const PyramidCoordinatesOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    if (options.target_shape)
        require_same_faces(rest, *options.target_shape);
    impl_->unit = normal_unit(rest.points());
}

void PyramidCoordinates::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const std::optional<SurfaceMesh> scaled = in_unit(rest(), self.unit);
    const SurfaceMesh& mesh = scaled ? *scaled : rest();
    if (!self.assembled)
        self.assembled.emplace(mesh, options().side, options().target_shape.get(), self.unit);
    progress.tick(0.2, "factorising");
    auto next = std::make_unique<const Binding>(*self.assembled, mesh, self.unit, regions, progress);
    progress.tick(1.0, "bound");

    self.bound = std::move(next);
    self.factorizations += 1;
    report.factorizations = self.factorizations;
    // For a moment the factor is there in double precision.
    const std::int64_t factor = self.bound->cells.factor().bytes();
    report.factor_bytes = factor + std::max(factor, self.bound->start.factor_bytes());
}

std::vector<int> PyramidCoordinates::folded_rings() const
{
    const AccessLock shared = reading();
    std::vector<int> both;
    if (!impl_->assembled)
        return both;
    const std::vector<int>& own = impl_->assembled->weights.folded;
    if (!impl_->assembled->morph)
        return own;
    std::ranges::set_union(own, impl_->assembled->morph->folded(), std::back_inserter(both));
    return both;
}

void PyramidCoordinates::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<PyramidCoordinates&>(other).impl_;
    std::swap(impl_->assembled, others.assembled);
    std::swap(impl_->factorizations, others.factorizations);
    std::swap(impl_->bound, others.bound);
}

SolveReport PyramidCoordinates::deform(const SolveRequest& request, const Targets& given,
                                       Points& positions) const
{
    const Impl& self = *impl_;
    const Binding& bound = *self.bound;
    const PyramidCells& cells = bound.cells;
    const Morph* const asked = std::get_if<Morph>(&request.extra);
    const double share = asked ? asked->share : 0.0;
    const PyramidMorph* const morph = self.assembled->morph && share > 0 ? &*self.assembled->morph : nullptr;
    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    const Targets targets = work->targets.of(given, view(bound.rest), bound.unit);
    work->goals.set(regions(), targets);
    if (morph)
        morph_goals(bound, regions(), targets, morph->target(), share, work->goals);
    if (cells.moving_count() == 0) {
        positions = bound.unit * work->goals.held;
        return {.converged = true};
    }

    const PyramidShape* shape = &bound.shape;
    if (morph || targets.incoming) {
        shape = &work->shape;
        if (morph)
            morph->mix(cells, self.assembled->rings, targets.rest, targets.base(), share, work->shape,
                       work->turns);
        else
            cells.keep(targets.base(), work->shape);
    }
    PyramidProblem problem(cells, *shape, options().similarity, work->goals.held, work->goals.pulls,
                           work->buffers);
    if (request.start) {
        work->x.resize(cells.moving_count(), 3);
        parallel_for(cells.moving_count(),
                     [&](int p) { work->x.row(p) = request.start->row(cells.order()[p]) / bound.unit; });
    } else {
        // The cascade keeps sizes, so where rings may grow it gets poses without their mean size.
        const double scale = options().similarity ? scale_of(targets.poses) : 1.0;
        Poses poses = targets.poses;
        for (Pose& pose : poses)
            pose /= scale;
        bound.start.rotations({poses, targets.rest, targets.incoming, targets.from_rest}, work->cascade,
                              work->rotations);
        parallel_for(cells.cell_count(), [&](int c) {
            Eigen::Quaterniond R = work->rotations[cells.order()[c]];
            if (morph)
                R = R * work->turns[c];
            problem.set_rotation(c, scale * R.toRotationMatrix());
        });
        problem.global_step(work->x);
    }
    SolveReport report =
        minimize(problem, work->x,
                 {.max_iterations = request.max_iterations.value_or(options().max_iterations),
                  .tolerance = request.tolerance.value_or(options().tolerance),
                  .floor = rounding_floor * problem.scale(),
                  .plain_steps = plain_steps},
                 request.progress, &work->descent);
    report.energy *= bound.unit * bound.unit;
    problem.place(work->x, positions);
    for (const std::vector<int>& part : bound.idle_parts) {
        const PointsView goal = view(work->goals.held);
        const RigidFit motion(part, view(positions), goal);
        for (const int v : part)
            if (morph)
                positions.row(v) = motion(positions.row(v).transpose()).transpose();
            else
                positions.row(v) = goal.row(v);
    }
    positions *= bound.unit;
    return report;
}

} // namespace sinew
