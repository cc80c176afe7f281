// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/attachments.h"
#include "native/core/options.h"
#include "native/core/progress.h"
#include "native/core/read_write_lock.h"
#include "native/core/report.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sinew {

/// How far PyramidCoordinates goes to its target shape, in [0, 1].
struct Morph
{
    double share;
};

/// (g, 3) how far each control point of a SplineSurface is moved from where the handles lead it, in the order of
/// its control_grids().
struct GridMoves
{
    PointsView moves;
};

/// The arguments of SurfaceMethod::solve().
struct SolveRequest
{
    Poses poses{}; ///< (k) affine maps in object space, one per handle, from its rest to its posed state
    std::optional<PointsView> incoming{}; ///< (n, 3) the shape to deform in this frame; without one, the rest
    /// (k) whether the pose of each handle applies to the rest shape instead of the incoming one; without
    /// these flags, all poses apply to the incoming shape.
    std::optional<std::vector<bool>> from_rest{};
    /// (n, 3) the shape from which an iterative method starts while a control is dragged; its result then
    /// depends on this shape.
    std::optional<PointsView> start{};
    std::optional<int> max_iterations{}; ///< of an iterative method; without it, those of its options
    std::optional<double> tolerance{}; ///< likewise
    Progress progress{};
    /// In how many steps the handles go to their poses, at least 1; see SurfaceMethod::Stepping.
    int substeps = 1;
    /// What one method alone takes. The others do not read it.
    std::variant<std::monostate, Morph, GridMoves> extra{};
};

/// A deformation of a surface by handles on it.
///
///   call            repeat it when ...               cost
///   constructor     rest shape or options changed    assembly, O(n) at most
///   set_handles()   another set of handles           the factorisation
///   rebind()        instead of set_handles(), to     from nothing to a whole factorisation
///                   take over an earlier object's
///                   factor
///   solve()         the handles moved                no factorisation; safe from several threads at once
///
/// All calls may come from several threads. One that binds has its objects to itself: it waits until others
/// have ended, and others wait for it. Calls from within a progress callback cannot wait and throw
/// ObjectInUse.
class SurfaceMethod
{
public:
    virtual ~SurfaceMethod() = default;

    /// Leaves the object as it was if it throws.
    /// \param free_parts  what parts without a handle do. Those that follow are in no system: solve() reads
    ///   their motion off the solved points.
    /// \throw InvalidConstraint    see Regions.
    /// \throw InvalidOption        see Attachments.
    /// \throw FactorizationFailed  a system is singular; a vertex is named.
    /// \throw Cancelled            by `progress`.
    /// \throw ObjectInUse          in a progress callback of another call on this object.
    BindReport set_handles(const std::vector<Handle>& handles, const Progress& progress = {},
                           const FreeParts& free_parts = {});

    /// set_handles(), taking over from `former` what is still valid. The report says how much that was, and
    /// what differs between the two objects. If can_reuse() is true, `former` has no handles afterwards;
    /// otherwise it stays as it was. Leaves both objects as they were if it throws.
    /// \throw as set_handles()
    BindReport rebind(SurfaceMethod& former, const std::vector<Handle>& handles,
                      const Progress& progress = {}, const FreeParts& free_parts = {});

    /// Whether rebind() would take anything over: `former` has handles, it is of the same class and has the
    /// same rest shape, and only options differ that the method can update.
    bool can_reuse(const SurfaceMethod& former) const;

    /// Names of what differs from `former` and changes the result of a bind, beside the handles: "method",
    /// "rest shape", or options; empty for nothing. A method around another one asks its base.
    std::vector<std::string> differences(const SurfaceMethod& former) const;

    /// With substeps, handles go from rest to their poses on the way of PathOfPoses, and soft ones pull from
    /// where the last step left them. The shape depends on the poses alone, and not on how a drag got there.
    /// The report is that of the last step.
    /// \param[out] positions  (n, 3) deformed points; before set_handles(), the incoming shape.
    /// \throw InvalidConstraint  see Targets::check; or `start` has another size or is not finite.
    /// \throw InvalidOption      max_iterations < 0, tolerance < 0, substeps < 1 or a morph not in [0, 1].
    /// \throw InvalidConstraint  a pose in the middle of substeps that are made anew has no inverse; the
    ///   element of the error is a handle.
    /// \throw FactorizationFailed  a shape in the middle of them cannot be bound.
    /// \throw Cancelled          by the request's progress.
    SolveReport solve(const SolveRequest& request, Points& positions) const;

    /// The rest shape, with_sides_of_the_whole().
    const SurfaceMesh& rest() const { return *rest_; }
    /// What the last bind was for; the next one replaces it.
    const Regions& regions() const { return regions_; }
    /// As in the last set_handles() or rebind().
    FreeParts free_parts() const { return attachments_ ? attachments_->options() : FreeParts{}; }
    /// For calls that read what a bind made, and for several calls between which no bind may come.
    AccessLock reading() const { return {AccessLock::reading, access_}; }

    /// What substeps do. Where the shape is linear in the poses, the steps add up to one, unless the
    /// equations are made anew.
    enum class Stepping {
        none, ///< nothing: one step does
        from_last, ///< each step starts from the shape of the last one (SolveRequest::start)
        anew ///< each step binds the shape of the last one as its rest shape, which takes as many binds
    };
    virtual Stepping stepping() const { return Stepping::none; }

    /// True if the result does not depend on the incoming shape, so that one solve can be used again for
    /// every shape that enters under the same poses.
    virtual bool displaces_all_alike() const { return false; }

protected:
    explicit SurfaceMethod(const SurfaceMesh& rest);
    SurfaceMethod(SurfaceMethod&&) noexcept = default;

    AccessLock changing() { return {AccessLock::changing, access_}; }
    /// set_handles() for a caller that has the object to itself.
    BindReport hold(const std::vector<Handle>& handles, const Progress& progress,
                    const FreeParts& free_parts);
    /// Factorises for these regions and completes the report. Must leave the object as it was if it throws.
    /// The element of a FactorizationFailed is a vertex.
    virtual void bind(const Regions& regions, BindReport& report, const Progress& progress) = 0;
    /// Computes the deformed points after bind(); those of idle parts may be left out where they ride.
    /// \param targets  the targets of the request, which have been checked.
    virtual SolveReport deform(const SolveRequest& request, const Targets& targets,
                               Points& positions) const = 0;
    /// A method with the same options for another rest shape, where stepping() is `anew`.
    virtual std::unique_ptr<SurfaceMethod> made_anew(const SurfaceMesh& rest) const;
    /// Whether the vertices of parts that no handle touches get their places after deform().
    bool idle_parts_ride() const { return !attachments_->rides().empty(); }
    /// Names of the options that change the result of bind() and differ from those of `former`, an object of
    /// the same class.
    virtual std::vector<std::string> changed_options(const SurfaceMethod& former) const = 0;
    /// Whether bind() can start from a factor for another value of this option.
    virtual bool updates(const std::string& option) const = 0;
    /// Exchanges all that bind() made with an object of the same class and rest shape.
    virtual void swap_binding(SurfaceMethod& other) = 0;

    /// \throw InvalidConstraint  there are more or fewer points than the rest shape has, or one is not
    ///   finite.
    void require_same_size(const PointsView& points, const char* name) const;

private:
    struct Comparison
    {
        std::vector<std::string> changed; ///< names of what differs, without the handles
        bool reusable;
    };
    Comparison compare(const SurfaceMethod& former) const;
    void swap_all(SurfaceMethod& other);
    SolveReport deform_in_steps(Stepping kind, const SolveRequest& request, const Targets& targets,
                                Points& positions) const;
    /// The last attached parts if they serve these handles, too.
    std::shared_ptr<const Attachments> attachments_for(const Regions& regions, const FreeParts& free_parts,
                                                       const Progress& progress) const;
    /// Takes over other attached parts and keeps the factor.
    BindReport follow(const FreeParts& free_parts, const Progress& progress);
    /// Says what a breakdown at a vertex means for a mesh, and what to do.
    [[noreturn]] void refuse(const FactorizationFailed& failure) const;

    std::shared_ptr<const SurfaceMesh> rest_; ///< shared, so that its address stays when the method is moved
    Components parts_;
    Regions regions_;
    std::shared_ptr<const Attachments> attachments_; ///< null before the first bind
    BindReport report_;
    bool bound_ = false;
    mutable ReadWriteLock access_;
};

/// A surface method whose options have a table, see core/options.h.
template <class OptionsOfMethod>
class SurfaceMethodWith : public SurfaceMethod
{
public:
    using Options = OptionsOfMethod;
    const Options& options() const { return *options_; }

protected:
    /// \throw InvalidOption  an option is not in its range.
    SurfaceMethodWith(const SurfaceMesh& rest, const Options& options)
        : SurfaceMethod(rest), options_(std::make_shared<const Options>(options))
    {
        require_valid(options);
    }

    std::vector<std::string> changed_options(const SurfaceMethod& former) const override
    {
        return changed(options(), static_cast<const SurfaceMethodWith&>(former).options());
    }
    bool updates(const std::string& option) const override { return is_updated<Options>(option); }

    std::shared_ptr<const Options> options_; ///< shared, so that its address stays when the method is moved
};

} // namespace sinew
