// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/read_write_lock.h"
#include "native/core/report.h"
#include "native/core/types.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sinew {

/// What SpaceMethod::bind() or rebind() did.
struct SpaceReport
{
    Reuse reuse = Reuse::anew;
    std::string changed; ///< what differs from the earlier object: "cage, points"; empty for nothing
    int point_count = 0;
    std::vector<int> outside; ///< points outside the control
    double dropped = 0.0;     ///< how much the threshold changed the weights, see PointWeights::dropped()
    double error = 0.0; ///< estimate of the largest error of a weight; 0 where the method has a closed form
    std::vector<std::string> remarks; ///< what the control cannot carry, and what is used instead
    std::int64_t weight_bytes = 0; ///< memory of the weights
    double seconds = 0.0;          ///< wall clock time of the call
};

/// Where warp() writes: (n, 3) numbers, row-major, which the caller owns.
using PositionsOut = std::variant<double*, float*>;

/// A deformation of the space around points by a control. The control consists of points: the vertices of a
/// cage or lattice, handle points, or points of curves.
///
///   call          repeat it when ...           cost
///   constructor   the rest control changed     the part of bind() that is the same for all points
///   bind()        the points changed           the weights of each point
///   rebind()      instead of bind(), to take   nothing if nothing differs, otherwise that of bind()
///                 over an earlier object's
///                 weights
///   warp()        the control moved            O(n), without weights; safe from several threads at once
///
/// All calls may come from several threads. One that binds has its objects to itself: it waits until others
/// have ended, and others wait for it. Calls from within a progress callback cannot wait and throw
/// ObjectInUse.
class SpaceMethod
{
public:
    virtual ~SpaceMethod() = default;
    SpaceMethod(const SpaceMethod&) = delete;
    SpaceMethod& operator=(const SpaceMethod&) = delete;

    /// Leaves the object as it was if it throws.
    /// \param points  (n, 3) rest points, in the frame of the control.
    /// \throw InvalidConstraint  points are not finite, or the method has no weights for them.
    /// \throw OutOfMemory, Cancelled
    /// \throw ObjectInUse        in a progress callback of another call on this object.
    SpaceReport bind(PointsView points, const Progress& progress = {});

    /// bind(), taking over the weights of `former` if can_reuse() is true; then `former` has no bound points
    /// afterwards. Leaves both objects as they were if it throws.
    /// \throw as bind()
    SpaceReport rebind(SpaceMethod& former, PointsView points, const Progress& progress = {});

    /// Whether `former` has the weights that bind() would compute: it has the same class, control, options
    /// and points.
    bool can_reuse(const SpaceMethod& former, const PointsView& points) const;

    /// Adds the displacements of the bound points to the incoming shape.
    /// \param control   (c, 3) the posed control.
    /// \param incoming  (n, 3) the shape to deform in this frame; without one, the bound points.
    /// \param out       (n, 3)
    /// \param room      expected number of rows of `out`: checked against n if given.
    /// \throw InvalidConstraint  no points are bound, `control`, `incoming` or `out` has another size, or a
    ///   number is not finite.
    void warp(PointsView control, const std::optional<PointsView>& incoming, PositionsOut out,
              std::optional<Eigen::Index> room = {}) const;

    /// (n, 3) the bound points; the next bind replaces them.
    const Points& points() const { return points_; }
    /// For calls that read what a bind made, and for several calls between which no bind may come.
    AccessLock reading() const { return {AccessLock::reading, access_}; }

protected:
    /// \param control_name  what the control is called in messages: "cage".
    explicit SpaceMethod(const char* control_name) : control_name_(control_name) {}
    const char* control_name() const { return control_name_; }

    /// The shape that a warp deforms, checked as warp() does; the caller holds reading().
    /// \throw InvalidConstraint  as warp()
    PointsView checked_base(const std::optional<PointsView>& incoming,
                            std::optional<Eigen::Index> room) const;

    /// Computes what warp() needs and completes the report. Must leave the object as it was if it throws.
    virtual void compute(PointsView points, SpaceReport& report, const Progress& progress) = 0;
    /// Writes base + displacements to `out`.
    /// \param base  (n, 3)
    virtual void displace(PointsView control, PointsView base, PositionsOut out) const = 0;
    /// Names of the settings that differ from those of an object of the same class; the control is one of
    /// them.
    virtual std::vector<std::string> changed_settings(const SpaceMethod& former) const = 0;
    /// Exchanges all that compute() made with an object of the same class and settings.
    virtual void swap_weights(SpaceMethod& other) = 0;

private:
    SpaceReport hold(PointsView points, const Progress& progress);
    std::vector<std::string> differences(const SpaceMethod& former, const PointsView& points) const;
    void swap_all(SpaceMethod& other);

    const char* control_name_;
    Points points_;
    SpaceReport report_;
    bool bound_ = false;
    mutable ReadWriteLock access_;
};

/// A space method whose bind makes one object, or one array.
template <class Weights>
class SpaceMethodWith : public SpaceMethod
{
protected:
    using SpaceMethod::SpaceMethod;

    void swap_weights(SpaceMethod& other) override
    {
        std::swap(weights_, static_cast<SpaceMethodWith&>(other).weights_);
    }

    Weights weights_;
};

} // namespace sinew
