// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sinew {

/// What SurfaceMethod::solve() is asked.
struct SolveRequest
{
    Poses poses{}; ///< (k) affine maps from each handle's rest frame, object space
    std::optional<PointsView> incoming{}; ///< (n, 3) what entered this frame; none for rest
    std::optional<std::vector<bool>> from_rest{}; ///< (k) which handles aim from rest; none: no handle does
    /// (n, 3) warm start while a control is dragged; the result of an iterative method then depends on it.
    std::optional<PointsView> start{};
    std::optional<int> max_iterations{}; ///< of an iterative method; none for the budget of its options
    std::optional<double> tolerance{}; ///< likewise
    Progress progress{};
};

/// A deformation of a surface by handles on it.
///
///   call            repeat it when ...               cost
///   constructor     rest shape or options changed    assembly, O(n) at most
///   set_handles()   another set of handles           the factorisation
///   rebind()        instead of both: takes over      from nothing to a whole factorisation
///                   what an earlier object has
///   solve()         the handles moved                no factorisation; safe from several threads at once
class SurfaceMethod
{
public:
    virtual ~SurfaceMethod() = default;

    /// Leaves the object as it was if it throws.
    /// \throw InvalidConstraint    see Regions.
    /// \throw FactorizationFailed  a system is singular.
    /// \throw Cancelled            by `progress`.
    BindReport set_handles(const std::vector<Handle>& handles, const Progress& progress = {});

    /// set_handles(), taking over what still holds from `former`, which has no handles afterwards where
    /// can_reuse() is true, and stays as it was elsewhere. The report says what was taken over and what
    /// differs. Leaves both objects as they were if it throws.
    /// \throw as set_handles()
    BindReport rebind(SurfaceMethod& former, const std::vector<Handle>& handles,
                      const Progress& progress = {});

    /// Whether rebind() would take anything over: the same class on the same rest shape, with handles, and no
    /// option differs but those that the method updates.
    bool can_reuse(const SurfaceMethod& former) const;

    /// \param[out] positions  (n, 3) deformed points. Before set_handles(): what entered.
    /// \throw InvalidConstraint  see Targets::check; `start` of another size or not finite.
    /// \throw InvalidOption      max_iterations < 0 or tolerance < 0.
    /// \throw Cancelled          by the request's progress.
    SolveReport solve(const SolveRequest& request, Points& positions) const;

    const SurfaceMesh& rest() const { return *rest_; }
    const Regions& regions() const { return regions_; }

protected:
    explicit SurfaceMethod(const SurfaceMesh& rest);
    SurfaceMethod(SurfaceMethod&&) noexcept = default;

    /// Factorises for these regions and completes the report. Must leave the object as it was if it throws.
    virtual void bind(const Regions& regions, BindReport& report, const Progress& progress) = 0;
    /// \param targets  those of the request, checked.
    virtual SolveReport deform(const SolveRequest& request, const Targets& targets,
                               Points& positions) const = 0;
    /// Names of the options of which bind() makes something else than `former`, an object of the same class.
    virtual std::vector<std::string> changed_options(const SurfaceMethod& former) const = 0;
    /// Whether bind() can make use of a factor for another value of this option.
    virtual bool updates(const std::string& option) const = 0;
    /// Exchanges all that bind() made with an object of the same class and rest shape.
    virtual void swap_binding(SurfaceMethod& other) = 0;

    /// \throw InvalidConstraint  another number of points than the rest shape has, or one is not finite.
    void require_same_size(const PointsView& points, const char* name) const;

private:
    struct Comparison
    {
        std::vector<std::string> changed; ///< names of what differs, handles left out
        bool reusable;
    };
    Comparison compare(const SurfaceMethod& former) const;
    void swap_all(SurfaceMethod& other);

    std::shared_ptr<const SurfaceMesh> rest_; ///< does not move when the method does
    Components parts_;
    Regions regions_;
    BindReport report_;
    bool bound_ = false;
};

} // namespace sinew
