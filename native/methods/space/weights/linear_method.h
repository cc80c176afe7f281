// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/method.h"
#include "native/methods/space/weights/point_weights.h"

#include <vector>

namespace sinew {

/// A space method that moves points by weights times the moves of control columns:
///
///     x' = x + W (c' - c),    c the columns of the rest control, c' those of the posed one
///
/// This equals W c' if W c = x, and gives exactly the rest points if the control is at rest, however the
/// weights are rounded. A point whose weights are all zero stays at rest. warp() is one (n, k) x (k, 3)
/// product with the precision of the weights; with single precision, its error is 1e-7 of the longest move of
/// a control.
class LinearSpaceMethod : public SpaceMethod
{
public:
    const PointWeights& weights() const { return weights_; }

protected:
    LinearSpaceMethod(const char* control_name, const PointWeightOptions& options)
        : SpaceMethod(control_name), weight_options_(options)
    {
    }

    /// (c, 3) the control at rest.
    virtual PointsView rest_control() const = 0;
    /// \throw InvalidConstraint  the posed control does not fit the rest one, or is not finite.
    virtual void check_control(PointsView control) const = 0;

    /// Points in the frame in which prepare() and evaluate() compute.
    virtual PointsView normalized(PointsView points, Points&) const { return points; }
    /// Prepares evaluate(); bind() calls it once. Must leave the object as it was if it throws.
    /// \return the share of the time of bind() that it takes. It reports its progress within that share.
    virtual double prepare(PointsView, const Progress&) { return 0.0; }
    /// The weights of a block of points, one row per point. Several threads call it at once.
    /// \param first         index of the block's first point among those that prepare() got.
    /// \param[out] rows     (b, columns())
    /// \param[out] outside  (b) whether each point lies outside.
    virtual void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const = 0;

    /// Number of columns of the weights: one per point of the control, and in Green coordinates also one per
    /// triangle of the cage. Columns behind those of the points are for vectors, which a translation does not
    /// change.
    virtual int columns() const { return static_cast<int>(rest_control().rows()); }
    /// (columns(), 3) the points and vectors that the weights are multiplied by, for a posed control.
    virtual void controls(PointsView control, Points& controls) const { controls = control; }
    /// Whether points outside have weights; if not, bind() refuses them.
    virtual bool reaches_outside() const { return true; }
    /// How many points evaluate() gets at once, a multiple of PointWeights::part.
    virtual int block_size() const { return PointWeights::part; }
    /// Completes the report after all weights have been computed.
    virtual void finish(SpaceReport&) const {}
    /// Frees what prepare() made for these points; bind() calls it at its end, also when it throws.
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
