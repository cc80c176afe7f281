// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/method.h"
#include "native/methods/space/nonlinear/fields/field_kernels.h"

#include <vector>

namespace sinew {

/// What a tool does to the space around it.
enum class FieldTool {
    drag,  ///< a ball moves and turns with the tool
    twist, ///< what lies above the tool turns about the tool's z axis
    bend   ///< what lies above the tool turns about axes across its z axis
};

/// The settings of tools. Each vector holds one value for all tools, or one per tool.
constexpr auto choices(FieldTool)
{
    return std::array{Choice{"drag", FieldTool::drag}, Choice{"twist", FieldTool::twist},
                      Choice{"bend", FieldTool::bend}};
}

struct VectorFieldOptions
{
    std::vector<int> counts{}; ///< frames on the path of each tool; empty: all frames are those of one tool
    std::vector<FieldTool> tools{FieldTool::drag};
    std::vector<double> inner{0.5}, outer{1.0};
    std::vector<double> width{1.0};
    int order = 4;
    int steps = 0;
    double tolerance = 1e-5;

    static constexpr auto table()
    {
        using O = VectorFieldOptions;
        return std::tuple{
            option("tools", &O::tools, Rebind::anew,
                   "'drag', 'twist' or 'bend', or (k,) of them: a ball moves and turns with the tool; what "
                   "lies above the tool turns about its z axis; or about axes across that"),
            option_of_each(
                "inner", &O::inner, any_number(),
                "within this distance of a drag, all moves with the tool; below this height over a "
                "twist or bend, which may be negative, nothing turns"),
            option_of_each("outer", &O::outer, any_number(),
                           "more than inner: beyond it, nothing moves, or all turns"),
            option_of_each("width", &O::width, more_than(0),
                           "within this distance of the axis of a twist or bend all turns, and at twice the "
                           "distance nothing does"),
            option("order", &O::order, Rebind::anew, between(1, 4),
                   "1, 2 or 4, of the Runge-Kutta rule, if steps is given"),
            option("steps", &O::steps, Rebind::anew, between(0, 4096),
                   "on each piece of a path; 0 for as many as each point needs"),
            option("tolerance", &O::tolerance, Rebind::anew, at_least(1e-12),
                   "of a point on one piece of a path, as a share of outer, if steps is 0")};
    }
};

/// Deformation by the flow of vector fields without divergence, which tools make on their way.
///
/// A. Angelidis, M.-P. Cani, G. Wyvill, S. King. "Swirling-Sweepers: Constant Volume Modeling." Graphical
/// Models 68(4), 2006. W. von Funck, H. Theisel, H.-P. Seidel. "Vector Field Based Shape Deformations." ACM
/// Transactions on Graphics 25(3), 2006. Tutorial, section 7.
///
/// A point x follows dx/dt = grad p x grad q, which has no divergence: volumes stay, and the flow neither
/// tears nor folds space. Where a tool acts fully, p and q are linear for its velocity v, and linear and
/// quadratic for its angular velocity w; where it does not act, one of them is constant; and between them
/// b(u) = 4 u^3 (1 - u) + u^4 blends. With y = x - c for the centre c of the tool, and beta the share in
/// which it acts:
///
///   drag   beta = 1 - b((|y| - inner) / (outer - inner)). p and q of the velocity are both multiplied by
///          beta, and of the turn p is the integral of beta along the axis:
///              (beta^2 + beta beta' |y|) v - beta beta' / |y| (y . v) y + beta w x y
///   twist  beta = b((a . y - inner) / (outer - inner)) for the axis a, times phi = 1 - b(d / width - 1) for
///          the distance d from the axis; w is along a, and p the integral of beta phi:
///              beta phi w x y, whose flow has a closed form
///   bend   the same beta and phi; w is across the tool's axis a. With y = h a + n e + m w / |w| and
///          e = w x a / |w|, the sum of two such fields with p = beta phi |w| h m, q = h, and
///          p = -beta phi |w| n^2 / 2, q = m:
///              curl(beta phi A) = beta phi w x y + grad(beta phi) x A,   A = h (w . y) a - n^2 / 2 w
///          A vanishes on the axis, so what gives way does so around the bent part, and not along it. In
///          beta, a lies halfway between the axis of the tool at rest and now, so that neither side of the
///          bend runs into the region of the other. With the tool in the middle of the blend, inner = -outer,
///          a bar keeps its length best.
///
/// The control is a path per tool: its frames, in order, from rest on. Between two frames the tool moves and
/// turns evenly, by less than half a turn. The tools act one after the other. So a shape depends on the paths
/// and not on how they came about, and the way back restores it. Frames may be scaled: the lengths of a drag
/// are scaled likewise. A drag of points in the inner ball is rigid, exactly.
/// A twist counts only the turns about the tool's axis, a bend only those across it, and neither its moves.
///
/// All else is integrated with a field that changes with time, which a step sees at t, t + h / 2 and t + h
/// (Runge-Kutta of order 4). Each point chooses the lengths of its steps by itself, so that it does not
/// depend on others: a step is compared with two of half its length, and must differ from them by less than
/// its share of the tolerance.
///
///   call          repeat it when ...            cost
///   constructor   the rest frames changed       O(frames)
///   bind()        the points changed            O(points), to copy them
///   warp()        the tools moved               O(points in reach x pieces x steps)
///
/// Memory: nothing per point but the 24 bytes that every space method keeps.
class VectorField : public SpaceMethod
{
public:
    /// \param frames  (4 f, 3) the frames of the paths at rest, tool after tool, each as four points: the
    ///   origin and the ends of its three axes. All frames of one tool are the same.
    /// \throw InvalidConstraint  a number is not finite, or the frames of a tool differ or are flat (the
    ///   elements are tools).
    /// \throw InvalidOption      an option is out of its range, or there is another number of values.
    explicit VectorField(Points frames, const VectorFieldOptions& options = {});

    int tool_count() const { return static_cast<int>(tools_.size()); }
    /// Pieces of the path that the tools take from rest, where something moves.
    /// \throw InvalidConstraint  as warp()
    int piece_count(PointsView control) const;
    /// The field of one piece at a time in [0, 1]. (n, 3)
    /// \throw InvalidConstraint  as warp(), or there is no such piece.
    Points velocities(PointsView control, int piece, double time, PointsView points) const;

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod&) override {}

private:
    struct Tool
    {
        int begin, count; ///< its frames
        FieldTool kind;
        double inner, outer, width;
        Matrix3 to_rest; ///< the inverse of the axes at rest
        Vector3 axis; ///< z at rest
    };
    /// A frame as a rigid motion from rest, with its centre and scale.
    struct Frame
    {
        Matrix3 turn;
        Vector3 centre;
        double scale;
    };
    /// What points are moved by, one after the other.
    struct Stage
    {
        FieldPiece piece{};
        bool twists = false; ///< by piece.turn about piece.centre
        Matrix3 turn = Matrix3::Identity(); ///< of the whole piece
        double most_outer = 0.0, least_inner = 0.0;
        int steps = 1; ///< to begin with
        double tolerance = 0.0; ///< a length
    };

    void add_tools();
    std::vector<Stage> stages(PointsView control) const;
    void add_stages(const Tool& tool, PointsView control, std::vector<Stage>& found) const;
    Frame frame(const Tool& tool, PointsView control, int number) const;
    /// \param bent, end  the turns of the axis before and after the piece
    /// \param from, to   the axis before and after it
    Stage bend(const Tool& tool, const Matrix3& bent, const Matrix3& end, const Vector3& from,
               const Vector3& to) const;
    Stage drag(const Tool& tool, const Frame& from, const Frame& to) const;
    void finish(const Tool& tool, double motion, Stage& stage) const;
    /// \param[in,out] points  (3, lanes)
    void move(const Stage& stage, int count, double* points) const;

    Points frames_;
    VectorFieldOptions options_;
    std::vector<Tool> tools_;
};

} // namespace sinew
