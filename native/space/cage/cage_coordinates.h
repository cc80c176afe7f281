// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/space/cage/cage.h"
#include "native/space/cage/cage_weights.h"

namespace sinew {

/// What bind() did.
struct CageReport
{
    int point_count = 0;
    std::vector<int> outside;      ///< points outside the cage
    double dropped = 0.0; ///< largest sum of the magnitudes dropped at a point, see CageWeightOptions
    double error = 0.0; ///< estimate of the largest error of a weight; 0 where the form is closed
    std::int64_t weight_bytes = 0; ///< memory of the weights
    double seconds = 0.0; ///< wall clock of bind()
};

/// The `bind` and `warp` of every cage method: weights of points, and their product with a posed cage.
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

    /// \param vertices        (c, 3) posed cage vertices.
    /// \param[out] positions  (n, 3)
    /// \throw InvalidConstraint  nothing is bound; see Cage::check_pose.
    void warp(PointsView vertices, Points& positions) const;

    const Cage& cage() const { return cage_; }
    const CageWeights& weights() const { return weights_; }

protected:
    CageCoordinates(Cage cage, const CageWeightOptions& options) : cage_(std::move(cage)), options_(options)
    {
    }

    /// What all weights need, once before them. Must leave the object as it was if it throws.
    /// \return the share of the time of bind() that it takes, which `progress` is counted within.
    virtual double prepare(PointsView, const Progress&) { return 0.0; }
    /// Weights of a block of points, a point a row. Called from several threads at once.
    /// \param[out] rows     (b, columns())
    /// \param[out] outside  (b) whether each point lies outside.
    virtual void evaluate(PointsView block, RowMatrix& rows, std::vector<char>& outside) const = 0;

    /// Columns of the weights: cage vertices, with Green coordinates also its triangles.
    virtual int columns() const { return cage_.vertex_count(); }
    /// (columns(), 3) what the weights are multiplied by, for a posed cage.
    virtual void controls(PointsView vertices, Points& controls) const { controls = vertices; }
    /// Whether points outside have weights; if not, bind() names them.
    virtual bool reaches_outside() const { return true; }
    /// The method's own part of the report, after all points.
    virtual void finish(CageReport&) const {}

private:
    Cage cage_;
    CageWeightOptions options_;
    CageWeights weights_;
    bool bound_ = false;
};

} // namespace sinew
