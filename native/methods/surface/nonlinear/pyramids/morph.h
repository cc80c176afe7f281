// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/surface/nonlinear/pyramids/cells.h"
#include "native/methods/surface/nonlinear/pyramids/rings.h"

#include <Eigen/Geometry>

#include <span>
#include <vector>

namespace sinew {

/// The rigid motion that takes some points as close as possible to others, in the sense of least squares.
struct RigidFit
{
    Eigen::Matrix3d R;
    Vector3 from, to; ///< the means

    RigidFit(std::span<const int> vertices, const PointsView& before, const PointsView& after);
    Vector3 operator()(const Vector3& point) const { return to + R * (point - from); }
};

/// Some points of a mesh on the way between two of its shapes. The mean goes straight and the best rotation
/// evenly; what is left of the difference is added bit by bit. At both ends the points are exactly there.
class RegionMorph
{
public:
    RegionMorph(std::span<const int> vertices, const PointsView& from, const PointsView& to, double t);
    Vector3 at(const Vector3& from, const Vector3& to) const
    {
        return middle_ + turn_ * ((1 - t_) * (from - fit_.from) + t_ * (fit_.R.transpose() * (to - fit_.to)));
    }

private:
    RigidFit fit_;
    double t_;
    Vector3 middle_;
    Matrix3 turn_;
};

/// Mixes the pyramid coordinates of two shapes of one mesh: their weights w, edges e and tips d. Those of the
/// second shape are turned onto those of the first, ring by ring.
///
/// The cells measure with the weights w0 of the first shape. A tip by other weights w is the same as
/// d + sum_j (w - w0)_ij e_ij by these, so the mixture of the weights needs no factor of its own.
class PyramidMorph
{
public:
    /// \param shares   w0
    /// \param target   (n, 3) the second shape.
    PyramidMorph(const Rings& rings, const std::vector<double>& shares, Points target);

    const Points& target() const { return target_; }
    /// The vertices where the second shape gives no mean-value weights; see Rings.
    const std::vector<int>& folded() const { return weights_.folded; }

    /// \param rest        (n, 3) the shape that the target belongs to.
    /// \param base        (n, 3) the first shape: what `rest` has become.
    /// \param t           in [0, 1].
    /// \param[out] shape  the mixture.
    /// \param[out] turns  one per cell: the rotation of its ring from the first shape to the mixture, if the
    ///                    target goes where the rest went.
    void mix(const PyramidCells& cells, const Rings& rings, const PointsView& rest, const PointsView& base,
             double t, PyramidShape& shape, std::vector<Eigen::Quaterniond>& turns) const;

private:
    Points target_;
    Rings::Weights weights_;
    std::vector<double> differences_; ///< w1 - w0, one per directed edge of the rings
};

} // namespace sinew
