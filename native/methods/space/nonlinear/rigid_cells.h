// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/nonlinear/handles/handle_method.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace sinew {

struct RigidCellsOptions
{
    int cells = 2000;
    int levels = 2;
    int max_iterations = 40;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = RigidCellsOptions;
        return std::tuple{
            option("cells", &O::cells, Rebind::anew, between(8, 100'000), "about how many"),
            option("levels", &O::levels, Rebind::anew, between(0, 6),
                   "how many levels larger cells may be inside of closed surfaces"),
            iteration_limit(&O::max_iterations, "of a warp, rejected trials included"),
            stopping_tolerance(
                &O::tolerance,
                "a warp ends when the relative decrease of the energy is below this twice in succession")};
    }
};

/// Space deformation by rigid cubes that elastic joints couple at their common sides.
///
/// M. Botsch, M. Pauly, M. Wicke, M. Gross. "Adaptive Space Deformations Based on Rigid Cells." Computer
/// Graphics Forum 26(3), 2007. Tutorial, section 7.
///
/// The cells are those of CellGrid: cubes of an octree, fine at the surface and larger inside. Cells only
/// move rigidly, so that the two copies of a common side (that of the smaller cell, of area a) come apart by
/// d(s, t). The energy is
///
///     E = sum over sides  a^2 / (V_i + V_j)  int_0^1 int_0^1 |d(s, t)|^2 ds dt
///
/// V the volumes of the parts of both cells behind the side. As for prisms
/// (methods/surface/nonlinear/primo.h), with m the gap in the middle and u, v half of the side's edges, the
/// integral is |m|^2 + |(R_i - R_j) u|^2 / 3 + |(R_i - R_j) v|^2 / 3: the energy of RigidBodies. A point
/// follows the cells around it,
///
///     x' = sum_i w_i(x) (R_i (x - c_i) + t_i)
///
/// with smooth weights that sum to 1, see CellGrid::shares(). The points of a handle follow it exactly, and
/// those around it, up to one side of the finest cells away, partly, see HandleReach.
///
/// Departs from the paper: V counts only what lies behind the side, as a fine cell would otherwise be coupled
/// to a coarse one three times too softly. The weights of points are compact radial ones, so that a frame
/// solves nothing for them, instead of triharmonic functions. A cell that holds points of a handle follows
/// it, also where its pose is not rigid; of several handles in one cell, the one with most points. A handle
/// without a cell of its own is refused, unless it is far outside and another handle is close to what it
/// would take hold of, see holds(). A piece of the shape without a handle holds on to the piece next to it,
/// if that is near, see are_near(), and stays if none is. Points that are held by less than 1 pull the centre
/// of their cell. Centres and rotations move together, by L-BFGS with two constant factors, from the answer
/// of coarser graphs of cells, which depends on the poses alone.
///
/// With an incoming shape, the displacements of the rest shape are added to it.
///
///   call           repeat it when ...             cost
///   constructor    the shape or handles changed   a copy
///   bind()         the points changed             voxels, two factorisations for the cells, weights
///   warp()         the handles moved              three solves and two fits per cell and iteration, then one
///                                                 pass over the points: about 10 cells and 84 bytes each
class RigidCells : public HandleMethod
{
public:
    /// \param surface  the shape that the cells fill: a mesh, open or closed, or points without faces.
    /// \throw InvalidOption      an option is out of range.
    /// \throw InvalidConstraint  by bind(): handles without a cell of their own.
    RigidCells(SurfaceMesh surface, HandlePoints handles, const RigidCellsOptions& options = {});
    ~RigidCells() override;

    /// The cells of the last bind, for drawing them and for tests.
    struct Cells
    {
        Points centres; ///< (m, 3) at rest
        std::vector<double> sides;
        std::vector<int> handles; ///< that hold them, or -1
        std::vector<std::array<int, 2>> links; ///< pairs of cells
    };
    /// \throw InvalidConstraint  before a bind
    Cells cells() const;

    /// From which start to minimise, for tests: that of the method, or the resting cells.
    enum class Start { cascade, rest };
    struct Answer
    {
        Points centres; ///< (m, 3), in the order of cells()
        SolveReport report;
    };
    Answer answer(const Poses& poses, Start start, double tolerance, int max_iterations) const;

protected:
    void build(PointsView points, SpaceReport& report, const Progress& progress) override;
    SolveReport deform(const std::vector<HeldMotion>& motions, PointsView base, bool enters,
                       PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    Network posed_network(const std::vector<HeldMotion>& motions, PointsView base,
                          bool enters) const override;
    void swap_binding(HandleMethod& other) override;

private:
    struct Binding;
    struct Workspace;
    class Solve;
    const Binding& bound() const;

    RigidCellsOptions options_;
    std::unique_ptr<const Binding> bound_;
};

} // namespace sinew
