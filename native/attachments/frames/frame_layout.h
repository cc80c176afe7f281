// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/host_surface.h"

#include <vector>

namespace sinew {

constexpr int most_frames = 64; ///< of an attached part

/// Where the frames of one attached part sit, and what share each vertex has in them.
///
/// The first frame sits at the vertex nearest the centroid, each further one at the vertex farthest from all
/// before along the part's own edges, until every vertex is within the bend length; there are at most
/// `most_frames`.
/// With cover = the distance that is left, at least the bend length, the shares are
///
///     phi_k(v) = max(0, 1 - (distance_k(v) / 2 cover)^2)^2,
///
/// less the fifth largest of the vertex, so that at most four remain, and then normalised.
///
/// A part with several frames that lies on the mirror plane of its host, and is its own image there, rides as
/// the mean of how it does and of the mirror image of that: so it stays on the plane where both sides of the
/// host move alike. For it each frame has an image, which follows all others, and both have half the shares.
struct FrameLayout
{
    double length = 0.0; ///< the bend length: a part that is shorter moves rigidly
    double cover = 0.0;
    double bending = 0.0; ///< from 0, where all frames move as one, to 1, where each is its own
    std::vector<int> seeds; ///< vertices of the part, one per frame that is no image
    std::vector<TriangleTree::Place> images; ///< of all vertices, on the part; empty without images of frames
    MatrixX shares; ///< (frames, vertices)
    MatrixX distances; ///< (frames, frames) along the part

    int frame_count() const { return static_cast<int>(shares.rows()); }
};

/// The bend length is `length`, or twice the part's thickness if that is more: a compact part is rigid at any
/// size. A part that wraps its host counts as thin; for it, the area of the host inside it is above half its
/// own.
/// \param host       with its tree, and its mirror plane sought.
/// \param stiffness  in [0, 1]; 1 makes all frames move as one.
FrameLayout lay_out_frames(const Part& part, const HostSurface& host, double length, double stiffness);

} // namespace sinew
