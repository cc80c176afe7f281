// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/space/cage/cage.h"
#include "native/space/weights/point_weights.h"

namespace sinew {

/// What bind() did.
struct CageReport
{
    int point_count = 0;
    std::vector<int> outside;      ///< points outside the cage
    double dropped = 0.0;          ///< what the threshold changed, see PointWeights::dropped()
    double error = 0.0; ///< estimate of the largest error of a weight; 0 where the form is closed
    std::int64_t weight_bytes = 0; ///< memory of the weights
    double seconds = 0.0; ///< wall clock of bind()
};

/// The `bind` and `warp` of every cage method: weights of points, and their product with a posed cage.
///
///     x' = x + W (c' - c),    c the controls of the rest cage, c' those of the posed one
///
/// which is W c' where W c = x, and gives the rest points back to the last bit where the cage is at rest,
/// however the weights are rounded. A point whose weights are all zero stays at rest.
///
///   call          repeat it when ...            cost
///   constructor   the rest cage changed         O(cage), harmonic: its boundary system
///   bind()        the points changed            O(points x cage)
///   warp()        the cage moved                one (n, k) x (k, 3) product
class CageCoordinates
{
public:
    virtual ~CageCoordinates() = default;

    /// Leaves the object as it was if it throws.
    /// \param points  (n, 3) rest points, in the frame of the cage.
    /// \throw InvalidConstraint  a point is not finite, or the method has no weights there; they are named.
    /// \throw OutOfMemory, Cancelled
    CageReport bind(PointsView points, const Progress& progress = {});

    /// Rounds to the precision of the weights: in single precision, 1e-7 of the longest move of a control.
    /// \param vertices        (c, 3) posed cage vertices.
    /// \param[out] positions  (n, 3)
    /// \throw InvalidConstraint  nothing is bound; see Cage::check_pose.
    void warp(PointsView vertices, Points& positions) const;
    /// \param[out] positions  (n, 3) row-major, n as bound.
    template <class Real>
    void warp(PointsView vertices, Real* positions) const; // float or double

    const Cage& cage() const { return cage_; }
    const PointWeights& weights() const { return weights_; }
    /// (n, 3) the points bound.
    const Points& points() const { return points_; }

protected:
    CageCoordinates(Cage cage, const PointWeightOptions& options) : cage_(std::move(cage)), options_(options)
    {
    }

    /// What all weights need, once before them. Must leave the object as it was if it throws.
    /// \return the share of the time of bind() that it takes, which `progress` is counted within.
    virtual double prepare(PointsView, const Progress&) { return 0.0; }
    /// Weights of a block of points, one row per point. Called from several threads at once, with parts of
    /// what prepare() got.
    /// \param first         number of the block's first point.
    /// \param[out] rows     (b, columns())
    /// \param[out] outside  (b) whether each point lies outside.
    virtual void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const = 0;

    /// Columns of the weights: cage vertices, with Green coordinates also its triangles. All but the vertices
    /// are multiplied by vectors, which no translation changes.
    virtual int columns() const { return cage_.vertex_count(); }
    /// (columns(), 3) what the weights are multiplied by, for a posed cage.
    virtual void controls(PointsView vertices, Points& controls) const { controls = vertices; }
    /// Whether points outside have weights; if not, bind() names them.
    virtual bool reaches_outside() const { return true; }
    /// Points that evaluate() gets at once, a multiple of PointWeights::part.
    virtual int block_size() const { return PointWeights::part; }
    /// The method's own part of the report, after all points.
    virtual void finish(CageReport&) const {}
    /// What prepare() made for these points alone may go: bind() ends, or throws.
    virtual void release() {}

private:
    void moves(PointsView vertices, Points& moves) const;

    Cage cage_;
    PointWeightOptions options_;
    PointWeights weights_;
    Points points_, rest_controls_;
    bool bound_ = false;
};

} // namespace sinew
