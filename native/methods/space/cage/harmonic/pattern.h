// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <vector>

namespace sinew {

/// The way in which every triangle of a cage is cut into panels of linear flux, which are triangles in
/// barycentric coordinates.
///
/// The flux is singular at the edges of the cage, so the finer patterns have rings of narrow strips there. It
/// is continuous within a face, and its values at the corners of the panels are the unknowns.
struct HarmonicPattern
{
    struct Panel
    {
        std::array<int, 3> corner, edge;
        std::array<double, 3> turn; ///< 1 if the edge runs counterclockwise around the panel, otherwise -1
        double area; ///< as a share of the area of the face
    };

    std::vector<Vector3> corners;
    std::vector<std::array<int, 2>> edges;
    std::vector<Panel> panels;
    int unknowns = 0; ///< the number of corners
    /// The distance from the middle of a triangle, in units of its radius, up to which the flux is not
    /// replaced by its linear part.
    double near_radii = 2.0;
    /// (3, unknowns) takes a flux to the linear flux closest to it in the least-squares sense, given at the
    /// corners of the face.
    MatrixX to_linear;
};

/// The patterns, from coarse to fine, have 3, 6, 12, 18, 27, 69 and 93 unknowns per triangle.
constexpr int harmonic_pattern_count = 7;
HarmonicPattern harmonic_pattern(int level);
/// The number of unknowns of a pattern, without making it.
int harmonic_pattern_unknowns(int level);

} // namespace sinew
