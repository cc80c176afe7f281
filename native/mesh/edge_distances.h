// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <limits>
#include <vector>

namespace sinew {

/// The edges of triangles and their lengths, for the shortest ways along them. Any number of threads may ask
/// at once.
class EdgeDistances
{
public:
    /// Cost: O(n log n).
    EdgeDistances(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles);

    /// The length of the shortest way from a vertex to each one; infinity where there is none, or none of at
    /// most `most`. Cost: O(n log n) for the n vertices within `most`.
    std::vector<double> from(int vertex, double most = std::numeric_limits<double>::infinity()) const;

private:
    std::vector<int> offsets_, neighbours_;
    std::vector<double> lengths_;
};

} // namespace sinew
