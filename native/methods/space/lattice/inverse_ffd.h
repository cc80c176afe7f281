// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/lattice/grid/rest_grid.h"
#include "native/methods/space/method.h"

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace sinew {

struct InverseFfdOptions
{
    std::array<int, 3> resolution{5, 5, 5}; ///< points of the lattice along each axis, from 2 to 16
    LatticeBasis basis = LatticeBasis::bspline;
    int degree = 3;
    /// Directions of control moves that the points see by less than this share of the most visible one stay
    /// still.
    double cut_off = 1e-3;
    /// The lattice fills the image of the cube from -1 to 1; without it, a box a tenth longer than that
    /// around the points and the handles, along the axes in which these are spread most and least.
    std::optional<Pose> frame;
    /// (c) in (0, 1], how much the squared error at each constraint counts; empty where all are 1.
    std::vector<double> weights{};
    /// (k) how many constraints each handle has, which moves them by one pose; empty if each is a handle.
    std::vector<int> counts{};
};

/// Inverse free-form deformation: the points that the artist drags are constraints, and the control points of
/// a lattice around the shape move as little as they can.
///
/// W. M. Hsu, J. F. Hughes, H. Kaufman. "Direct Manipulation of Free-Form Deformations." SIGGRAPH 1992.
/// Tutorial, section 5.1.
///
/// With B (c, l) the functions of l control points at c constraints, and q how far these were dragged,
///
///     delta = B^+ q,    x' = x + sum_i B_i(x) delta_i
///
/// B^+ is the pseudo-inverse, of which singular values below `cut_off` times the largest count as zero. Where
/// the control points can meet all constraints they do, by the moves of least squares; where they cannot, for
/// example where two constraints coincide, the errors have least squares, by their weights. Far from all
/// constraints nothing moves, so a translation of all of them is not one of the shape.
///
///   call          repeat it when ...            cost
///   constructor   the handles changed           nothing
///   bind()        the points changed            O(points + c l^2 + min(c, l)^3)
///   warp()        the handles moved             O(c l) and that of Ffd
///
/// Memory: as Ffd, and c l numbers.
class InverseFfd : public SpaceMethod
{
public:
    /// \param handles  (c, 3) the constraints at rest, c >= 1.
    /// \throw InvalidConstraint  there is none, some are not finite, there is another number of weights, or
    ///                           the counts do not sum to c.
    /// \throw InvalidOption      an option is out of range.
    explicit InverseFfd(PointsView handles, const InverseFfdOptions& options = {});

    /// The box around the faces of a surface, along the axes of its frame, for InverseFfdOptions::frame:
    /// loose vertices count nothing.
    static Pose box_around(const SurfaceMesh& surface);

    const HandlePoints& handles() const { return handles_; }
    /// (l, 3) the control points at rest, once points are bound.
    Points lattice() const;
    /// (l, 3) how far the control points move for dragged constraints (c, 3).
    Points control_moves(PointsView posed) const;
    /// How many independent motions the constraints have; fewer than c where some depend on others.
    int rank() const { return rank_; }

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    /// "handles" and "lattice".
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;

private:
    Points moves_for(PointsView posed) const;

    InverseFfdOptions options_;
    HandlePoints handles_; ///< of options_.counts and weights
    std::shared_ptr<const RestGrid> grid_;
    PlacedPoints placed_;
    MatrixX inverse_; ///< (l, c) B^+
    int rank_ = 0;
};

} // namespace sinew
