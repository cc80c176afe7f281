// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/points/rbf/incremental.h"
#include "native/methods/space/points/rbf/kernels.h"
#include "native/methods/space/points/rbf/system.h"
#include "native/methods/space/weights/linear_method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

constexpr auto choices(RbfFunction)
{
    return std::array{
        Choice{"triharmonic", RbfFunction::triharmonic}, Choice{"biharmonic", RbfFunction::biharmonic},
        Choice{"wendland_c0", RbfFunction::wendland_c0}, Choice{"wendland_c2", RbfFunction::wendland_c2},
        Choice{"wendland_c4", RbfFunction::wendland_c4}};
}

struct RbfOptions
{
    RbfFunction function = RbfFunction::triharmonic;
    int degree = 2;
    double radius = 0.5;
    double tolerance = 1e-4;
    WeightPrecision precision = WeightPrecision::single_precision;

    static constexpr auto table()
    {
        using O = RbfOptions;
        return std::tuple{
            option("kernel", &O::function, Rebind::anew,
                   "'triharmonic' (r^3, the smoothest), 'biharmonic' (-r), or a compact one: "
                   "'wendland_c0', 'wendland_c2' or 'wendland_c4'"),
            option("degree", &O::degree, Rebind::anew, between(-1, 2),
                   "of the polynomials that are reproduced. The triharmonic kernel uses at least 1, the "
                   "biharmonic one 0 or 1, compact ones at most 1. With -1, a compact kernel leaves points "
                   "beyond its radius at rest"),
            option("radius", &O::radius, Rebind::anew, at_least(1e-9),
                   "of a compact kernel, as a share of the diameter() of all points"),
            option("tolerance", &O::tolerance, Rebind::anew, at_least(0),
                   "if there are many points, handles of several are met up to this share of the longest "
                   "move of the control, with as few centres as that takes; 0 meets all exactly"),
            option("precision", &O::precision, Rebind::anew,
                   "of the functions of handles of several points: 'single' or 'double'")};
    }
};

/// Radial basis functions: the smoothest deformation of space that takes the points of the handles along.
///
/// J. Duchon. "Splines minimizing rotation-invariant semi-norms in Sobolev spaces." 1977.
/// M. Botsch, L. Kobbelt. "Real-Time Shape Editing using Radial Basis Functions." Eurographics 2005.
/// H. Wendland. "Piecewise polynomial, positive definite and compactly supported radial functions of minimal
/// degree." Advances in Computational Mathematics 4, 1995. Tutorial, section 5.3, Eq. 17.
///
///     d(x) = sum_j w_j phi(|x - c_j|) + p(x),   d(c_i) = d_i,   sum_j w_j p(c_j) = 0 for all p
///
/// phi(r) = r^3 with quadratic p is triharmonic and minimises the integral of the squared third derivatives,
/// as the best of the surface methods do; phi(r) = -r with affine p minimises that of the second ones, and
/// follows single points with a cone; the compact functions lead to a sparse system. The points are scaled to
/// the unit box. Where all handle points lie in a plane or on a quadric, the degree of p drops (see
/// rbf/polynomials.h), and the report says so.
///
/// If each handle is one point, these are the centres: a frame solves for w, O(c^2) for c of them, and adds
/// up O(n c) values of phi; nothing is stored per point. Handles of several points move by affine maps, so d
/// is a sum of 4 functions per handle, which bind() evaluates: a frame is their product with the maps. Then
/// few of the points may be centres, see rbf/incremental.h. A compact function visits only the m centres near
/// each point, by a grid of the centres and an order of the points in which neighbours are near in space.
///
/// Departs from the papers: handle points that nearly coincide are one centre, which goes to the mean of
/// their targets by the weights of HandlePoints; and a nearly singular system gets a tiny diagonal.
///
///   call           repeat it when ...       cost
///   constructor    the handles changed      nothing
///   bind()         the points changed       O(c^3 / 3) for a dense system, or the incremental fit; and for
///                                           handles of several points O(n c)
///   warp()         the handles moved        O(n c), or O(n k) for k handles of several points
///
/// With a compact function, the system is sparse and O(n c) is O(n m).
///
/// Memory per point: 24 bytes, and 16 (single precision) or 32 bytes for each handle of several points; or 4
/// for a compact function of single points.
class Rbf final : public LinearSpaceMethod
{
public:
    /// \throw InvalidOption  an option is outside its range.
    explicit Rbf(HandlePoints handles, const RbfOptions& options = {});
    ~Rbf() override;

    const HandlePoints& handles() const { return handles_; }
    /// (c, 3) the centres, after bind().
    Points centres() const;
    /// After bind(): by how much handle points miss their targets, as a share of the longest move of a
    /// control point.
    double error() const;

protected:
    PointsView rest_control() const override { return view(handles_.control()); }
    void check_control(PointsView control) const override { handles_.check(control); }
    double prepare(PointsView points, const Progress& progress) override;
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    void finish(SpaceReport& report) const override;
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;
    int block_size() const override { return (is_compact(basis_.function) ? 8 : 1) * PointWeights::part; }

private:
    struct Solved;
    struct Eight;
    double reach() const; ///< of a centre, in the unit box
    void evaluate(const Solved& solved, PointsView block, RowMatrix& rows) const;
    template <class Real>
    void add_sums(const std::vector<double>& table, const RowMatrix& polynomial, PointsView base,
                  Real* out) const;

    HandlePoints handles_;
    RbfOptions options_;
    RbfBasis basis_;
    std::shared_ptr<const Solved> solved_; ///< of these handles and options, whatever points are bound
    std::vector<int> order_; ///< of a compact function: the bound points, near ones side by side
};

} // namespace sinew
