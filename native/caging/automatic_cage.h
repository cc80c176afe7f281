// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/caging/fineness.h"
#include "native/core/options.h"
#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <string>
#include <vector>

namespace sinew {

/// All lengths are shares of the size of the target (mesh/frames/surface_frame.h).
struct AutomaticCageOptions
{
    enum class Symmetry {
        automatic, ///< mirrored along the axis along which the target is best, if its sides differ by <= 0.02
        none,
        x, ///< mirrored along x, around the target and its mirror image
        y, ///< the same along y
        z, ///< the same along z
    };

    int faces = 300; ///< number of triangles wanted, 12 to 100,000; a quad counts as two
    double margin = 1.0 / 60.0; ///< distance from the target at which the cage is begun, 0.004 to 0.25
    Symmetry symmetry = Symmetry::automatic;
    /// In the coordinates of the target: beside them the cage is finer, and has more faces than `faces`, at
    /// most `most_faces`.
    std::vector<Detail> details{};
    int most_faces = 600;
    bool quads = false; ///< join triangles into quads where the cage is good with either diagonal
};
constexpr auto choices(AutomaticCageOptions::Symmetry)
{
    return std::array{
        Choice{"automatic", AutomaticCageOptions::Symmetry::automatic},
        Choice{"none", AutomaticCageOptions::Symmetry::none}, Choice{"x", AutomaticCageOptions::Symmetry::x},
        Choice{"y", AutomaticCageOptions::Symmetry::y}, Choice{"z", AutomaticCageOptions::Symmetry::z}};
}

struct AutomaticCageReport
{
    int wanted = 0; ///< number of triangles asked for, with those beside details
    int faces = 0; ///< number of triangles; a quad counts as two
    int quads = 0; ///< how many pairs of these triangles are quads
    bool reached = false; ///< whether there are no more faces than wanted; one more in a symmetric cage
    std::string reason{}; ///< why it has more faces than wanted; empty where they were reached
    int mirror_axis = -1; ///< 0 to 2, or -1 for a cage without symmetry
    /// The greatest distance from the mirror image of a vertex to the target, for the best axis or the one
    /// asked for; 0 where no symmetry is wanted.
    double asymmetry = 0.0;
    int wrap_faces = 0; ///< number of triangles of the fine surface that was simplified
    double margin = 0.0; ///< the margin of that surface, more than wanted where the target has many holes
    double clearance = 0.0; ///< distance from the cage to the closest vertex of the target
    double seconds = 0.0;
};

struct AutomaticCage
{
    Points points;
    std::vector<int> counts; ///< corners of each face: 3, or 4
    std::vector<int> corners; ///< face after face, outward
    AutomaticCageReport report;
};

/// Makes a coarse cage around any target. The cage is closed and does not cross itself, its faces look
/// outward, and the whole target is inside.
///
/// A wrap of the target (wrapped()) is simplified outwards and tightened (ProgressiveHull), down to half of
/// its distance. A symmetric cage is one half and its mirror image, about the plane through the object's
/// origin if the target is symmetric about that, else through its centroid (MirrorTest): exact to
/// the last bit about the origin, else to rounding. The result is checked, not assumed: each edge has two
/// faces that run along it in opposite directions, no two faces cross, no face of the target meets the cage,
/// and each part lies inside. Where the check fails, or a wrap with many holes cannot become as coarse as
/// wanted, wraps with twice and four times the margin are tried, and the result is the coarsest good cage.
///
/// Open borders of the target are closed by fans first, so that the wrap does not grow into an open neck.
/// Loose vertices count nothing, unless no face has an area: then all points are inside. All is computed on a
/// grid of 1.5e-5 of the size: so the unit of length, the place and the order of vertices and faces choose
/// nothing, and neither do last bits. Cost: grows as (size / margin)^2; 1 s with the default margin.
///
/// \throw InvalidOption  `faces` or `margin` is out of range.
/// \throw InvalidMesh    all points are in one place or too far apart to measure, or no good cage was found.
/// \throw Cancelled      by `progress`.
AutomaticCage automatic_cage(const SurfaceMesh& target, const AutomaticCageOptions& options = {},
                             const Progress& progress = {});

} // namespace sinew
