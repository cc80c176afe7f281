// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/surface/linear/pyramid/progressive_levels.h"
#include "native/methods/surface/linear/pyramid/ring_frames.h"

#include <functional>
#include <vector>

namespace sinew {

/// The way from one level of a progressive hierarchy to the next finer one, by relaxation [GSS99]: each new
/// vertex, and then each of them and of their neighbours some times more, goes to
///
///     x_i = sum_j w_ij x_j,    w_ij = - sum_e c_ei c_ej / sum_e c_ei^2,
///
/// where the second differences D_e x = sum_l c_el x_l around it are least; the sweeps go half of the way.
/// Their coefficients are those of the rest shape, so that a plane is relaxed into itself. What the level has
/// beyond that, d, is kept in the frames of the relaxed level:
///
///     d_i = F_i^T (y_i - relaxed(y)_i),    x_i = relaxed(x)_i + F'_i d_i.
///
/// Vertices that handles touch, and those without second differences, neither relax nor have details.
class RelaxedLevel
{
public:
    /// \param touched  (n) whether a handle holds or pulls each vertex.
    RelaxedLevel(const Points& rest, const ProgressiveLevel& level, const std::vector<bool>& touched);

    /// What the two passes below need besides the points.
    struct Workspace
    {
        std::vector<Vector3> moved;
    };

    /// \param[in,out] y   (n, 3) a shape that has details; it is as before when the call ends.
    /// \param[out] details  (moving) one per vertex.
    void analyse(Points& y, int sweeps, std::vector<Vector3>& details, Workspace& work) const;

    /// \param[in,out] x  (n, 3) the coarser level is there, and this one afterwards.
    /// \param fallback  (n) the frame of each vertex where the shape that is made has none there.
    void synthesise(Points& x, int sweeps, const std::vector<Vector3>& details, Workspace& work,
                    const std::function<Matrix3(int vertex)>& fallback) const;

    std::size_t bytes() const;

private:
    /// Rows of weights that sum to 1.
    struct Stencils
    {
        std::vector<int> offsets{0}, vertices;
        std::vector<double> weights;

        Vector3 at(int row, const Points& x) const
        {
            Vector3 sum = Vector3::Zero();
            for (int k = offsets[row]; k < offsets[row + 1]; ++k)
                sum += weights[k] * x.row(vertices[k]).transpose();
            return sum;
        }
    };

    void relax(Points& x, int sweeps, Workspace& work) const;
    void put(const Workspace& work, Points& x) const;

    std::vector<int> inserted_, moving_; ///< the new vertices; those that relax
    Stencils predictions_, relaxations_;
    RingFrames frames_; ///< of the moving vertices
};

} // namespace sinew
