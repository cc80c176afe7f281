// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sinew {

/// What SpaceMethod::bind() or rebind() did.
struct SpaceReport
{
    Reuse reuse = Reuse::anew;
    std::string changed; ///< what differs from the earlier object: "cage, points"; empty for none
    int point_count = 0;
    std::vector<int> outside;      ///< points outside the control
    double dropped = 0.0;          ///< what the threshold changed, see PointWeights::dropped()
    double error = 0.0; ///< estimate of the largest error of a weight; 0 where the form is closed
    std::int64_t weight_bytes = 0; ///< memory of the weights
    double seconds = 0.0; ///< wall clock of the call
};

/// Where warp() writes: (n, 3) numbers, row-major, which the caller owns.
using PositionsOut = std::variant<double*, float*>;

/// A deformation of the space around points by a control: the vertices of a cage or lattice, handle points,
/// points of curves.
///
///   call          repeat it when ...           cost
///   constructor   the rest control changed     a part of bind() that is the same for all points
///   bind()        the points changed           the weights of each point
///   rebind()      instead of both: takes over  nothing where nothing differs, else as they do
///                 what an earlier object has
///   warp()        the control moved            O(n), no weights; safe from several threads at once
class SpaceMethod
{
public:
    virtual ~SpaceMethod() = default;
    SpaceMethod(const SpaceMethod&) = delete;
    SpaceMethod& operator=(const SpaceMethod&) = delete;

    /// Leaves the object as it was if it throws.
    /// \param points  (n, 3) rest points, in the frame of the control.
    /// \throw InvalidConstraint  a point is not finite, or the method has no weights there; they are named.
    /// \throw OutOfMemory, Cancelled
    SpaceReport bind(PointsView points, const Progress& progress = {});

    /// bind(), taking over the weights of `former` where can_reuse() is true; no points are bound to that
    /// afterwards. Leaves both objects as they were if it throws.
    /// \throw as bind()
    SpaceReport rebind(SpaceMethod& former, PointsView points, const Progress& progress = {});

    /// Whether `former` has the weights that bind() would compute: the same class, control, options and
    /// points.
    bool can_reuse(const SpaceMethod& former, const PointsView& points) const;

    /// The displacements of the bound points, added to what entered.
    /// \param control   (c, 3) the posed control.
    /// \param incoming  (n, 3) what entered this frame; none for the bound points.
    /// \param out       (n, 3)
    /// \throw InvalidConstraint  nothing is bound; `control` or `incoming` of another size or not finite.
    void warp(PointsView control, const std::optional<PointsView>& incoming, PositionsOut out) const;

    /// (n, 3) the points bound.
    const Points& points() const { return points_; }

protected:
    SpaceMethod() = default;

    /// Computes what warp() needs and completes the report. Must leave the object as it was if it throws.
    virtual void compute(PointsView points, SpaceReport& report, const Progress& progress) = 0;
    /// \param base  (n, 3) what the displacements are added to.
    virtual void displace(PointsView control, PointsView base, PositionsOut out) const = 0;
    /// Names of the settings, the control among them, that differ from those of an object of the same class.
    virtual std::vector<std::string> changed_settings(const SpaceMethod& former) const = 0;
    /// Exchanges all that compute() made with an object of the same class and settings.
    virtual void swap_weights(SpaceMethod& other) = 0;
    /// What moves the points, for messages: "cage".
    virtual const char* control_name() const = 0;

private:
    std::vector<std::string> differences(const SpaceMethod& former, const PointsView& points) const;
    void swap_all(SpaceMethod& other);

    Points points_;
    SpaceReport report_;
    bool bound_ = false;
};

} // namespace sinew
