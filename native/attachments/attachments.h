// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/system/kept.h"
#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"

#include <optional>
#include <vector>

namespace sinew {

/// What parts do that no handle touches.
struct FreeParts
{
    bool follow = false; ///< ride on the parts that handles drive; otherwise stay in the incoming shape
    /// How stiff the attached parts are: one number or one per vertex, in [0, 1], of which each part takes
    /// the mean. With 0 the size of a part decides how it bends, with 1 every part moves as one rigid body.
    std::vector<double> stiffness{0.0};

    bool operator==(const FreeParts&) const = default;
};

/// Parts without a handle that ride on parts that have one.
///
/// At bind every attached part gets 1 to 64 frames (frame_layout.h), each with a patch of the surface beneath
/// it (attachment_frames.h). In a frame of the animation these are fitted to their patches (moving_frames.h)
/// and smoothed over the part, and its vertices follow with the shares phi_k:
///
///     R_k = the rotation closest to sum_u S_ku R_u,       ln s_k, x_k, o_k = sums of S_ku times those of u,
///     v'  = sum_k phi_k(v) (s_k R_k (v - o_k) + x_k),
///
/// and of parts that bend, also by what this misses of the motion beneath (feet.h).
///
/// Parts that ride on the same one and touch each other ride as one (touching.h), so that a row of teeth
/// stays a row. Compact parts, and parts below 6 % of the diagonal of the driven ones, have one frame and
/// move rigidly; longer ones bend. A single vertex needs no frame (loose_vertices.h). Where all driven parts
/// make one similarity, so do the attached parts, to rounding. The result depends on the shapes before and
/// after the deformation alone.
///
///   call          repeat it when ...                         cost
///   constructor   the rest shape, the driven parts or the    0.4 ms per small part, 10 us per loose vertex
///                 options changed
///   move()        after each solve                           0.1 us per frame, 2 ns per rigid vertex
class Attachments
{
public:
    /// \param driven  one per part: whether a handle holds or pulls a vertex of it.
    /// \throw InvalidOption  a stiffness is not in [0, 1], or there are neither 1 nor n of them.
    /// \throw Cancelled      by `progress`.
    Attachments(const SurfaceMesh& rest, const Components& parts, std::vector<bool> driven, FreeParts options,
                const Progress& progress = {});
    ~Attachments();

    /// Whether a new object for these arguments, on the same mesh, would be the same.
    bool serves(const std::vector<bool>& driven, const FreeParts& options) const
    {
        return driven == driven_ && options == options_;
    }

    const FreeParts& options() const { return options_; }
    /// By rising part. Either all parts that are not driven ride, or none does: without the option, or where
    /// no driven part has an area.
    const std::vector<Ride>& rides() const { return rides_; }

    /// Writes the vertices of the attached parts.
    /// \param incoming           the shape before the deformation; without one, the rest.
    /// \param[in,out] positions  (n, 3) the deformed points of the driven parts.
    void move(const std::optional<PointsView>& incoming, Points& positions) const;

private:
    struct Level;
    struct Scratch;

    std::vector<bool> driven_;
    FreeParts options_;
    std::vector<Ride> rides_;
    Points rest_; ///< of the whole mesh
    std::vector<Level> levels_; ///< hosts before their attached parts
    mutable Kept<Scratch> scratch_; ///< so that a frame allocates nothing
};

} // namespace sinew
