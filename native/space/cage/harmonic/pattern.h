// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <vector>

namespace sinew {

/// How every cage triangle is cut into panels of linear flux: triangles in barycentric coordinates.
///
/// Flux is singular at the edges of the cage, so the richer patterns put rings of narrow strips there. It is
/// continuous within a face, and the corners of the panels are its unknowns.
struct HarmonicPattern
{
    struct Panel
    {
        std::array<int, 3> corner, edge;
        std::array<double, 3> turn; ///< 1: the edge runs along the panel counterclockwise; -1
        double area;                ///< share of the face's
    };

    std::vector<Vector3> corners;
    std::vector<std::array<int, 2>> edges;
    std::vector<Panel> panels;
    int unknowns = 0; ///< as many as corners
    /// From the middle of a triangle, in units of its circle: up to where its flux counts in full.
    double near_radii = 2.0;
    /// (3, unknowns) flux at the corners of the face that is closest to a given one in the mean of squares.
    MatrixX to_linear;
};

/// From the coarsest to the richest: 3, 6, 12, 18, 27, 69 and 93 unknowns a triangle.
constexpr int harmonic_pattern_count = 7;
HarmonicPattern harmonic_pattern(int level);
/// Without building it.
int harmonic_pattern_unknowns(int level);

} // namespace sinew
