// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/space/cage/harmonic/data.h"
#include "native/space/cage/harmonic/lattice.h"
#include "native/space/cage/harmonic/multigrid.h"

#include <vector>

namespace sinew {

/// Harmonic functions of a cage on a lattice whose lines are cut where they cross it, one a cage vertex: see
/// HarmonicMultigrid for the nodes.
///
/// In cubes that no triangle touches, a point gets the trilinear function of the corners less what their
/// second differences say it misses: exact for quadratics along the axes. Elsewhere, and so in parts thinner
/// than some two cubes, it gets what is linear between the closest point of the cage and whatever first lies
/// opposite, a cube or the cage again: non-negative, exact for linear functions and on the cage, and off by
/// what bends across that gap.
class HarmonicGrid
{
public:
    struct Weights
    {
        std::vector<float> rows; ///< (points, c) as they come out: slightly negative perhaps
        std::vector<char> inside;
        double error; ///< the largest difference, at some points, to a lattice of twice the step
    };

    /// Cost O(cells^2 + cells^3 of them inside).
    /// \param cells  along the longest side of the box around the cage.
    /// \throw OutOfMemory  what evaluate() needs for `points` is more than limit_memory() allows.
    HarmonicGrid(const Cage& cage, int cells);

    int node_count() const { return multigrid_.node_count(); }

    /// Cost O(nodes inside * c), and O(points * c). The same bits on any number of threads.
    /// \param checked  every how manieth point is checked for the error.
    /// \throw OutOfMemory, Cancelled
    Weights evaluate(PointsView points, int checked, const Progress& progress) const;

private:
    struct Reading;
    struct Readings;
    void read(const Vector3& at, int level, Reading& reading) const;
    void interpolate(const Vector3& at, const HarmonicLattice::Node& lowest, int level, double factor,
                     Reading& reading) const;
    Readings read(PointsView points, int step, int level, const std::vector<char>& inside) const;

    int columns_;
    HarmonicLattice lattice_;
    std::vector<HarmonicData> data_;
    HarmonicMultigrid multigrid_;
};

} // namespace sinew
