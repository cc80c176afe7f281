// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Lengths are shares of the diagonal of the target's bounding box.
struct AutomaticCageOptions
{
    enum class Symmetry {
        automatic, ///< about the first of x, y, z in which the target's vertices mirror to 1e-3
        none,
        x,
        y,
        z, ///< the cage of the target and its image, about the middle of its box
    };

    int faces = 300;            ///< triangles wanted, a quad counts as two; 12 to 100,000
    double margin = 1.0 / 60.0; ///< how far from the target the cage starts, 0.004 to 0.25
    Symmetry symmetry = Symmetry::automatic;
    bool quads = false;         ///< join triangles into quads where both diagonals are safe
};

struct AutomaticCageReport
{
    int faces = 0;          ///< triangles, a quad counts as two
    int quads = 0;          ///< of them, pairs of triangles
    bool reached = false;   ///< no more faces than wanted (a symmetric cage: at most one more)
    int mirror_axis = -1;   ///< 0 to 2, or -1 for a cage without symmetry
    int wrap_faces = 0;     ///< of the fine surface that was simplified
    double margin = 0.0;    ///< at which it was wrapped; more than asked where the target has many holes
    double clearance = 0.0; ///< distance from the cage to the closest vertex of the target
    double seconds = 0.0;
};

struct AutomaticCage
{
    Points points;
    std::vector<int> counts;  ///< corners of each face: 3, or 4
    std::vector<int> corners; ///< face after face, outward
    AutomaticCageReport report;
};

/// A coarse cage around any target: closed, embedded, looking outward, the whole target inside.
///
/// The target is wrapped (CageWrap), the wrap simplified outwards (ProgressiveHull) and tightened. The result
/// is checked, not assumed: each edge has two faces that run along it in both directions, no two faces cross,
/// no face of the target meets the cage and each part lies inside. Where the check fails, or a wrap of many
/// holes cannot become as coarse as wanted, wraps of twice and four times the margin are tried, and the
/// coarsest good cage is given.
///
/// Open borders of the target are closed by fans first, lest the wrap creep into an open neck. Loose vertices
/// are inside too. Deterministic. Cost: as (diagonal / margin)^2; 1 s at the default.
///
/// \throw InvalidOption  faces or margin out of range.
/// \throw InvalidMesh    all points in one place, or too far apart to measure; no good cage was found.
/// \throw Cancelled      by `progress`.
AutomaticCage automatic_cage(const SurfaceMesh& target, const AutomaticCageOptions& options = {},
                             const Progress& progress = {});

} // namespace sinew
