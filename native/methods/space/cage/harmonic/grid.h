// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/methods/space/cage/harmonic/data.h"
#include "native/methods/space/cage/harmonic/lattice.h"
#include "native/methods/space/cage/harmonic/multigrid.h"

#include <vector>

namespace sinew {

/// Harmonic functions of a cage, one per control point, on a lattice whose lines end where they cross the cage.
/// HarmonicMultigrid computes the values at the nodes; this class interpolates them.
///
/// In a cube that no triangle touches, the value at a point is the trilinear function of the corners,
/// corrected by their second differences; this is exact for quadratic functions along the axes. Elsewhere,
/// and so in all parts that are thinner than about two cubes, it is interpolated linearly between the closest
/// point of the cage and the first thing in the opposite direction, a cube or the cage again. This is not
/// negative, exact for linear functions and on the cage, and neglects the curvature across that gap.
class HarmonicGrid
{
public:
    struct Weights
    {
        std::vector<float> rows;  ///< (points, c) the weights, which may be slightly negative
        std::vector<char> inside; ///< (points) whether each point is inside
        double error; ///< the largest difference, at some points, from a lattice of twice the step
    };

    /// Cost: O(cells^2 + number of cells inside).
    /// \param cells  number of cells along the longest side of the box around the cage.
    /// \throw OutOfMemory  the lattice needs more than limit_memory() allows.
    HarmonicGrid(const Cage& cage, int cells);

    int node_count() const { return multigrid_.node_count(); }

    /// Cost: O(nodes inside * c + points * c). Results agree to the last bit on any number of threads.
    /// \param stride  the error is estimated at every `stride`-th point.
    /// \throw OutOfMemory  this needs more than limit_memory() allows.
    /// \throw Cancelled
    Weights evaluate(PointsView points, int stride, const Progress& progress) const;

private:
    struct Interpolation;
    struct Interpolations;
    void interpolate(const Vector3& at, int level, Interpolation& result) const;
    void interpolate_in_cube(const Vector3& at, const HarmonicLattice::Node& lowest, int level, double factor,
                             Interpolation& result) const;
    Interpolations interpolate(PointsView points, int step, int level, const std::vector<char>& inside) const;

    int columns_;
    HarmonicLattice lattice_;
    std::vector<HarmonicData> data_;
    HarmonicMultigrid multigrid_;
};

} // namespace sinew
