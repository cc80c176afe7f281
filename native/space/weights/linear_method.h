// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/method.h"
#include "native/space/weights/point_weights.h"

#include <vector>

namespace sinew {

/// A space method whose points move by weights times the moves of control columns:
///
///     x' = x + W (c' - c),    c the columns of the rest control, c' those of the posed one
///
/// which is W c' where W c = x, and gives the rest points back to the last bit where the control is at rest,
/// however the weights are rounded. A point whose weights are all zero stays at rest. warp() is one (n, k) x
/// (k, 3) product; it rounds to the precision of the weights: in single precision, 1e-7 of the longest move
/// of a control.
class LinearSpaceMethod : public SpaceMethod
{
public:
    const PointWeights& weights() const { return weights_; }

protected:
    explicit LinearSpaceMethod(const PointWeightOptions& options) : weight_options_(options) {}

    /// (c, 3) the control at rest.
    virtual PointsView rest_control() const = 0;
    /// \throw InvalidConstraint  the posed control does not fit the rest one, or is not finite.
    virtual void check_control(PointsView control) const = 0;

    /// What all weights need, once before them. Must leave the object as it was if it throws.
    /// \return the share of the time of bind() that it takes, which `progress` is counted within.
    virtual double prepare(PointsView, const Progress&) { return 0.0; }
    /// Weights of a block of points, one row per point. Called from several threads at once.
    /// \param first         row of the block's first point among those that prepare() got.
    /// \param[out] rows     (b, columns())
    /// \param[out] outside  (b) whether each point lies outside.
    virtual void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const = 0;

    /// Columns of the weights: the points of the control, with Green coordinates also the cage's triangles.
    /// All but those points are multiplied by vectors, which no translation changes.
    virtual int columns() const { return static_cast<int>(rest_control().rows()); }
    /// (columns(), 3) what the weights are multiplied by, for a posed control.
    virtual void controls(PointsView control, Points& controls) const { controls = control; }
    /// Whether points outside have weights; if not, bind() names them.
    virtual bool reaches_outside() const { return true; }
    /// Points that evaluate() gets at once, a multiple of PointWeights::part.
    virtual int block_size() const { return PointWeights::part; }
    /// The method's own part of the report, after all points.
    virtual void finish(SpaceReport&) const {}
    /// What prepare() made for these points alone may go: bind() ends, or throws.
    virtual void release() {}

    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    /// "precision" and "threshold".
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;

private:
    PointWeightOptions weight_options_;
    PointWeights weights_;
    Points rest_controls_;
};

} // namespace sinew
