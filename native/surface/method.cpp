// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/method.h"

#include "native/core/errors.h"

#include <algorithm>
#include <chrono>
#include <typeinfo>
#include <utility>

namespace sinew {

SurfaceMethod::SurfaceMethod(const SurfaceMesh& rest)
    : rest_(std::make_shared<const SurfaceMesh>(rest)), parts_(connected_components(*rest_)),
      regions_({}, parts_)
{
}

BindReport SurfaceMethod::set_handles(const std::vector<Handle>& handles, const Progress& progress)
{
    const AccessLock alone = changing();
    return hold(handles, progress);
}

BindReport SurfaceMethod::hold(const std::vector<Handle>& handles, const Progress& progress)
{
    const auto start = std::chrono::steady_clock::now();
    progress.tick(0.0, "assembling the energy");
    Regions regions(handles, parts_);
    BindReport report = regions.report();
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
    bound_ = true;
    return report;
}

void SurfaceMethod::refuse(const FactorizationFailed& failure) const
{
    if (failure.elements().empty())
        throw failure;
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

BindReport SurfaceMethod::rebind(SurfaceMethod& former, const std::vector<Handle>& handles,
                                 const Progress& progress)
{
    const AccessLock alone(AccessLock::changing, access_, former.access_);
    auto [changed, reusable] = compare(former);
    if (!former.bound_ || handles != former.regions_.handles())
        changed.emplace_back("handles");
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
    if (reusable && changed.empty()) {
        progress.tick(1.0, "taking over the factor");
        report = report_;
        report.reuse = Reuse::kept;
    } else {
        report = hold(handles, progress);
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
    if (!bound_) { // there are no handles yet
        positions = targets.base();
        return SolveReport{.converged = true};
    }
    return deform(request, targets, positions);
}

void SurfaceMethod::require_same_size(const PointsView& points, const char* name) const
{
    if (points.rows() != rest_->vertex_count())
        throw InvalidConstraint(std::string(name) + ": " + std::to_string(points.rows()) +
                                " points given for a rest shape of " + std::to_string(rest_->vertex_count()));
    if (!points.allFinite())
        throw InvalidConstraint(std::string(name) + ": NaN or infinite coordinates");
}

} // namespace sinew
