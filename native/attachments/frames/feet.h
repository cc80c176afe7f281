// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/frames/frame_layout.h"
#include "native/attachments/part.h"

#include <vector>

namespace sinew {

/// A place of the host beneath a vertex of a part that bends.
struct Foot
{
    Triangle corners;        ///< of the host's part
    double parts[3];         ///< how much each of them counts
    double share = 0.0;      ///< how far the vertex follows it
};

/// The feet of all vertices of a part: of each, the place of the host that is closest to it. If frames have
/// images, the images of the feet come after them, and both have half the shares. Frames are
/// fitted to patches, so they miss what bends less widely than these. A foot tells by how much: with f the
/// foot at rest, f' where the host has moved it, and M the map of the vertex, the vertex goes to
///
///     M(v) + share (f' - M(f)).
///
/// Similarities stay exact, as there f' = M(f).
///
/// The share is the sum of those of the frames, each times `trusted` of the frame; and 0 at edges of the part
/// whose feet are not joined over the host within twice the edge, plus the gaps, plus two edges of the host,
/// and rises from there over some edges: so a cloth over two limbs is not torn.
/// \param trusted  in [0, 1], one per frame.
/// Cost: a closest point per vertex.
std::vector<Foot> feet_of(const Part& part, const HostSurface& host, const FrameLayout& layout,
                          const VectorX& trusted);

} // namespace sinew
