// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/method.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/mesh/frames/sides.h"
#include "native/methods/surface/substeps.h"

#include <algorithm>
#include <chrono>
#include <typeinfo>
#include <utility>

namespace sinew {

namespace {

/// Says which of the parts without a handle ride. Either all of them do, or none.
void tell(const Attachments& attachments, BindReport& report)
{
    report.rides = attachments.rides();
    if (report.rides.empty())
        return;
    report.free_parts = 0;
    report.riding_vertices = std::exchange(report.free_vertices, {});
}

} // namespace

SurfaceMethod::SurfaceMethod(const SurfaceMesh& rest)
    : rest_(std::make_shared<const SurfaceMesh>(with_sides_of_the_whole(rest))),
      parts_(connected_components(*rest_)), regions_({}, parts_)
{
}

BindReport SurfaceMethod::set_handles(const std::vector<Handle>& handles, const Progress& progress,
                                      const FreeParts& free_parts)
{
    const AccessLock alone = changing();
    return hold(handles, progress, free_parts);
}

BindReport SurfaceMethod::hold(const std::vector<Handle>& handles, const Progress& progress,
                               const FreeParts& free_parts)
{
    const auto start = std::chrono::steady_clock::now();
    progress.tick(0.0, "assembling the energy");
    Regions regions(handles, parts_);
    std::shared_ptr<const Attachments> attachments = attachments_for(regions, free_parts, progress);
    BindReport report = regions.report();
    tell(*attachments, report);
    try {
        bind(regions, report, progress);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        refuse(failure);
    }
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report_ = report;
    regions_ = std::move(regions);
    attachments_ = std::move(attachments);
    bound_ = true;
    return report;
}

std::shared_ptr<const Attachments> SurfaceMethod::attachments_for(const Regions& regions,
                                                                  const FreeParts& free_parts,
                                                                  const Progress& progress) const
{
    std::vector<bool> driven(parts_.count, false);
    for (int v = 0; v < rest_->vertex_count(); ++v)
        if (!regions.is_idle(v))
            driven[parts_.labels[v]] = true;
    if (attachments_ && attachments_->serves(driven, free_parts))
        return attachments_;
    return std::make_shared<const Attachments>(*rest_, parts_, std::move(driven), free_parts, progress);
}

BindReport SurfaceMethod::follow(const FreeParts& free_parts, const Progress& progress)
{
    std::shared_ptr<const Attachments> attachments = attachments_for(regions_, free_parts, progress);
    progress.tick(1.0, "taking over the factor");
    BindReport report = report_, counted = regions_.report();
    report.free_parts = counted.free_parts;
    report.free_vertices = std::move(counted.free_vertices);
    report.riding_vertices.clear();
    tell(*attachments, report);
    report_ = report;
    attachments_ = std::move(attachments);
    return report;
}

void SurfaceMethod::refuse(const FactorizationFailed& failure) const
{
    if (failure.elements().empty())
        throw; // the failure that the caller has caught
    const int vertex = failure.elements().front(), own = parts_.labels[vertex];
    std::vector<int> part;
    for (int v = 0; v < rest_->vertex_count(); ++v)
        if (parts_.labels[v] == own)
            part.push_back(v);
    throw FactorizationFailed("the equations have no unique solution near vertex " + std::to_string(vertex) +
                                  ", in the part of the vertices " + list_some(part) +
                                  ": merge vertices that lie in one place, dissolve faces without area, or "
                                  "let a handle hold more of this part",
                              Error::Element::vertex, failure.elements());
}

SurfaceMethod::Comparison SurfaceMethod::compare(const SurfaceMethod& former) const
{
    if (typeid(*this) != typeid(former))
        return {{"method"}, false};
    if (!(*rest_ == *former.rest_))
        return {{"rest shape"}, false};
    const std::vector<std::string> changed = changed_options(former);
    return {changed, former.bound_ && std::ranges::all_of(changed, [this](const std::string& option) {
                         return updates(option);
                     })};
}

bool SurfaceMethod::can_reuse(const SurfaceMethod& former) const
{
    const AccessLock both(AccessLock::reading, access_, former.access_);
    return compare(former).reusable;
}

std::vector<std::string> SurfaceMethod::differences(const SurfaceMethod& former) const
{
    const AccessLock both(AccessLock::reading, access_, former.access_);
    return compare(former).changed;
}

BindReport SurfaceMethod::rebind(SurfaceMethod& former, const std::vector<Handle>& handles,
                                 const Progress& progress, const FreeParts& free_parts)
{
    const AccessLock alone(AccessLock::changing, access_, former.access_);
    auto [changed, reusable] = compare(former);
    if (!former.bound_ || handles != former.regions_.handles())
        changed.emplace_back("handles");
    const bool keeps_factor = reusable && changed.empty();
    if (former.bound_ && free_parts != former.free_parts())
        changed.emplace_back("free_parts");
    struct Exchange
    {
        SurfaceMethod &own, *other;
        ~Exchange()
        {
            if (other)
                own.swap_all(*other);
        }
    } undone{*this, reusable ? &former : nullptr};
    if (reusable)
        swap_all(former);
    BindReport report;
    if (keeps_factor) {
        report = follow(free_parts, progress);
        report.reuse = changed.empty() ? Reuse::kept : Reuse::updated;
    } else {
        report = hold(handles, progress, free_parts);
        report.reuse = reusable ? Reuse::updated : Reuse::anew;
    }
    report.changed = joined(changed);
    undone.other = nullptr;
    if (reusable && &former != this) {
        former.bound_ = false;
        former.regions_ = Regions({}, former.parts_);
    }
    return report;
}

void SurfaceMethod::swap_all(SurfaceMethod& other)
{
    if (this == &other)
        return;
    swap_binding(other);
    std::swap(regions_, other.regions_);
    std::swap(attachments_, other.attachments_);
    std::swap(report_, other.report_);
    std::swap(bound_, other.bound_);
}

SolveReport SurfaceMethod::solve(const SolveRequest& request, Points& positions) const
{
    const AccessLock shared = reading();
    const Targets targets{request.poses, view(rest_->points()), request.incoming,
                          request.from_rest ? &*request.from_rest : nullptr};
    targets.check(regions_.handle_count());
    if (request.start)
        require_same_size(*request.start, "start");
    require_at_least(request.max_iterations.value_or(0), 0, "max_iterations");
    require_at_least(request.tolerance.value_or(0.0), 0.0, "tolerance");
    require_at_least(request.substeps, 1, "substeps");
    if (const Morph* morph = std::get_if<Morph>(&request.extra))
        require_in_range(morph->share, between(0.0, 1.0), "morph");
    if (!bound_) { // there are no handles yet
        positions = targets.base();
        return SolveReport{.converged = true};
    }
    const Stepping kind = request.substeps > 1 ? stepping() : Stepping::none;
    const SolveReport report = kind == Stepping::none ? deform(request, targets, positions)
                                                      : deform_in_steps(kind, request, targets, positions);
    attachments_->move(request.incoming, positions);
    return report;
}

std::unique_ptr<SurfaceMethod> SurfaceMethod::made_anew(const SurfaceMesh& /*rest*/) const { return nullptr; }

SolveReport SurfaceMethod::deform_in_steps(Stepping kind, const SolveRequest& request, const Targets& targets,
                                           Points& positions) const
{
    const int count = request.substeps;
    const PathOfPoses path(request.poses, centre_of_handles(regions_, targets.base()));
    SolveReport report;
    Points last;
    Poses before;
    for (int k = 1; k <= count; ++k) {
        const auto tick = [&](double fraction) {
            request.progress.tick((k - 1 + fraction) / count, "solving a substep");
            return true;
        };
        tick(0.0);
        SolveRequest step = request;
        step.poses = k < count ? path.at(static_cast<double>(k) / count) : request.poses;
        const Poses now = step.poses;
        if (k > 1 && kind == Stepping::anew) {
            const std::unique_ptr<SurfaceMethod> method = made_anew(with_points(*rest_, last));
            method->set_handles(regions_.handles(),
                                Progress([&](double fraction, const char*) { return tick(fraction); }));
            step.poses = relative_poses(before, now);
            step.substeps = 1;
            step.incoming.reset();
            step.from_rest.reset();
            report = method->solve(step, positions);
        } else {
            step.start.reset();
            if (k > 1)
                step.start.emplace(view(last));
            const Targets aims{step.poses, targets.rest, targets.incoming, targets.from_rest};
            report = deform(step, aims, positions);
        }
        for (int v = 0; v < rest_->vertex_count(); ++v)
            if (regions_.is_idle(v)) // which deform() may have left out
                positions.row(v) = targets.base().row(v);
        last = positions;
        before = now;
    }
    return report;
}

void SurfaceMethod::require_same_size(const PointsView& points, const char* name) const
{
    if (points.rows() != rest_->vertex_count())
        throw InvalidConstraint(std::string(name) + ": " + std::to_string(points.rows()) +
                                " points given for a rest shape of " + std::to_string(rest_->vertex_count()));
    if (!all_finite(points))
        throw InvalidConstraint(std::string(name) + ": NaN or infinite coordinates");
}

} // namespace sinew
