// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/methods/surface/nonlinear/pyramids/kernels.h"
#include "native/methods/surface/nonlinear/pyramids/rings.h"
#include "native/solvers/single_factor.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// How stiff the cell of each vertex is.
struct PyramidStiffness
{
    std::vector<double> tips;  ///< k_i
    std::vector<double> sides; ///< c_i

    /// \param points  (n, 3) at rest.
    /// \param side    > 0: c_i is this over the number of edges of the ring. See PyramidCoordinates for k_i.
    PyramidStiffness(const SurfaceMesh& mesh, const Rings& rings, const Rings::Weights& weights, double side);

    /// alpha A of the ARAP energy that bends alike.
    double smoothing = 0.0;
};

/// The edges e_ij and tips d_i of the shape to be kept, in the order of PyramidCells.
struct PyramidShape
{
    std::vector<double> edges, tips; ///< three numbers each
};

/// The cells of pyramid coordinates,
///
///     F(x, R) = 1/2 sum_i (k_i |x_i - sum_j w_ij x_j - R_i d_i|^2 + c_i sum_j |x_j - x_i - R_i e_ij|^2)
///             + 1/2 sum_l s_l |x_l - t_l|^2,
///
/// with the factor of the Hessian in x for fixed rotations. Points have other numbers inside: the moving ones
/// come first, in the order in which the factor eliminates them.
class PyramidCells
{
public:
    /// \param moving  (n) the points to solve for. Each is connected with one that does not move or is
    /// pulled.
    /// \throw FactorizationFailed  names a vertex.
    PyramidCells(const Rings& rings, const std::vector<double>& shares, const PyramidStiffness& stiffness,
                 const std::vector<bool>& moving, const std::vector<SoftConstraint>& soft);

    int moving_count() const { return moving_; }
    /// Cells [0, cell_count()) are those that touch a moving point.
    int cell_count() const { return static_cast<int>(offsets_.size()) - 1; }
    const std::vector<int>& order() const { return order_; } ///< the vertex of each point
    const std::vector<int>& offsets() const { return offsets_; }
    const std::vector<int>& ends() const { return ends_; }

    struct Pull
    {
        int point;
        double stiffness;
    };
    const std::vector<Pull>& pulls() const { return pulls_; } ///< one per soft constraint, in their order
    const SingleFactor& factor() const { return factor_; }
    PyramidView view() const;

    /// That of points in space.
    /// \param points  (n, 3) by vertices.
    void keep(const PointsView& points, PyramidShape& shape) const;
    /// sum over the edges and tips of a cell of c |e|^2 and k |d|^2.
    double size(const PyramidShape& shape, int cell) const;

private:
    void factorize(const Rings& rings, const std::vector<double>& shares, const PyramidStiffness& stiffness,
                   const std::vector<bool>& moving, const std::vector<SoftConstraint>& soft,
                   const std::vector<double>& pulls);

    int moving_ = 0;
    std::vector<int> order_, offsets_{0}, ends_, backs_;
    std::vector<double> shares_, sides_, stiffness_;
    std::vector<Pull> pulls_;
    SingleFactor factor_;
};

} // namespace sinew
