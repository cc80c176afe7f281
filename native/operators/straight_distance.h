// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/operators/geodesic_distance.h"

#include <vector>

namespace sinew {

/// Straight distances from some points, such as vertices of a mesh: at a point x, the least of |x - p| + d
/// over the sources, with their places p and their own distances d >= 0.
///
/// J. L. Bentley. "Multidimensional Binary Search Trees Used for Associative Searching." Communications of
/// the ACM 18(9), 1975.
///
///   call         cost
///   constructor  O(k log k) for k sources
///   at()         O(log k) where they lie close together; safe from several threads
class StraightDistance
{
public:
    /// \param sources  one or more.
    StraightDistance(const SurfaceMesh& mesh, const std::vector<GeodesicDistance::Source>& sources);
    /// From some points, one or more.
    /// \param distances  d of each; empty where all are 0.
    explicit StraightDistance(const Points& points, const std::vector<double>& distances = {});

    double at(const Vector3& x) const;

private:
    struct Place
    {
        Vector3 point;
        double distance;
    };
    void sort(int begin, int end);
    void search(int begin, int end, const Vector3& x, double& nearest) const;

    std::vector<Place> places_; ///< of a range that is divided, the middle one lies between the others
    std::vector<char> axes_;    ///< along which each range is divided, at its middle
};

} // namespace sinew
