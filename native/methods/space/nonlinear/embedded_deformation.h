// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/nonlinear/handles/handle_method.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace sinew {

struct EmbeddedDeformationOptions
{
    int nodes = 300;
    double rotation = 1.0;
    double regularity = 10.0;
    double pulls = 100.0;
    int max_iterations = 40;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = EmbeddedDeformationOptions;
        return std::tuple{
            option("nodes", &O::nodes, Rebind::anew, at_least(1), "how many the graph has, see NearNodes"),
            option("rotation", &O::rotation, Rebind::anew, at_least(1e-6),
                   "weight of the maps of nodes being rotations"),
            option("regularity", &O::regularity, Rebind::anew, at_least(1e-6),
                   "weight of neighbours agreeing about where they are"),
            option("pulls", &O::pulls, Rebind::anew, at_least(1e-6),
                   "weight of handles being followed: they are soft"),
            iteration_limit(&O::max_iterations, "of a warp, rejected trials included"),
            stopping_tolerance(
                &O::tolerance,
                "a warp ends when the relative decrease of the energy is below this twice in succession")};
    }
};

/// Space deformation by a graph of affine maps that are nearly rotations.
///
/// R. W. Sumner, J. Schmid, M. Pauly. "Embedded Deformation for Shape Manipulation." ACM Transactions on
/// Graphics 26(3), 2007. Tutorial, section 7.
///
/// Nodes at places g_j of the shape, each with an affine map A_j and a translation t_j, move any points near
/// them (k = 4 nodes per point, w = (1 - d / d_max)^2, normalised, with d_max the distance to the fifth):
///
///     x' = sum_j w_j(x) (A_j (x - g_j) + g_j + t_j)
///
/// and minimise
///
///     E = w_rot sum_j Rot(A_j) + w_reg sum_j sum_(k in N(j)) |A_j (g_k - g_j) + g_j + t_j - g_k - t_k|^2
///       + w_con sum_p s_p |p' - q_p|^2
///
/// with Rot(A) = |A^T A - I|^2, the squared departures of the columns of A from unit length and right angles,
/// N(j) the nodes around node j, see DeformationGraph, and q_p where handles want their points. The weights
/// are 1, 10 and 100.
///
/// Departs from the paper: Rot counts the angle between two columns twice, as the norm does. Counted once, an
/// oblique stretch costs a quarter less than one along an axis, and the shape changes by up to 1 % of its
/// size with the axes that it is given in. Lengths are measured in mean edges of the graph, so that the
/// answer does not depend on the unit of length, and neither does the choice of the weights. A handle with
/// more points than the nodes around them need does not pull harder: with D_j = sum_p w_j(p) over all of
/// them, s_p = sum_j w_j(p) min(1, 1 / D_j). The place of a control without region pulls seven points: the
/// place, and one edge to each side, half as strongly, so that it turns and scales the shape, too. Distances
/// run along the surface, where there is one; see NearNodes. Instead of Gauss-Newton, which factorises 12 m
/// unknowns in each of 4 to 8 steps, E itself is minimised by L-BFGS with one constant factor of 4 m
/// unknowns, from rotations that are blended between the handles: a step takes three solves. The minimum is
/// the same.
///
/// The points of a handle follow it exactly, and those around it, up to one edge away, partly, see
/// HandleReach. A point of a handle that is far outside takes hold of nothing that another handle is close
/// to, see holds(). Pieces of the shape that are far from each other have nothing to do with each other, and
/// one that no handle takes hold of stays.
///
/// With an incoming shape, the graph rides on it: nodes and handle points enter where the vertices nearest to
/// them do, so animations and simulations are edited in each frame's own shape. Where handles rest, the
/// incoming shape comes out as it is.
///
///   call           repeat it when ...             cost
///   constructor    the shape or handles changed   a copy
///   bind()         the points changed             the graph, O(n log n) per few nodes, and one
///                                                 factorisation of 4 m unknowns; the weights of points
///   warp()         the handles moved              some steps of O(m), then one pass over the points: 36
///                                                 bytes per point are read, twelve numbers are blended
class EmbeddedDeformation : public HandleMethod
{
public:
    /// \param surface  the shape on which the nodes are: a mesh, or points without faces.
    /// \throw InvalidOption      nodes < 1, max_iterations < 1, or a weight or the tolerance is out of range.
    EmbeddedDeformation(SurfaceMesh surface, HandlePoints handles,
                        const EmbeddedDeformationOptions& options = {});
    ~EmbeddedDeformation() override;

    /// The graph of the last bind, for drawing it and for tests.
    struct Graph
    {
        Points nodes; ///< (m, 3) at rest
        std::vector<std::array<int, 2>> edges; ///< pairs a < b
        double edge_length = 1.0; ///< the mean
        Points pulls; ///< (pulls, 3) p
        std::vector<int> pull_handles{}; ///< (pulls); k where a node stays that no handle is near
        std::vector<double> strengths{}; ///< (pulls) s_p
        RowMatrix pull_weights{}; ///< (pulls, m) w_j(p)
    };
    /// \throw InvalidConstraint  before a bind
    Graph graph() const;
    /// (n, m + k) the weights of the bound points: of the nodes, and of the handles.
    RowMatrix weights() const;

    /// From which start to minimise, for tests: that of the method, or one that knows no rotations.
    enum class Start { handles, no_rotations };
    /// The unknowns A_j and g_j + t_j, (4 m, 3), and what was reached.
    struct Answer
    {
        Points unknowns;
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
    const Binding& bound() const;
    SolveReport solve(const std::vector<HeldMotion>& motions, PointsView base, bool enters,
                      Workspace& work) const;

    EmbeddedDeformationOptions options_;
    std::unique_ptr<const Binding> bound_;
};

} // namespace sinew
