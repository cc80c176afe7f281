// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/find_hosts.h"
#include "native/attachments/frames/feet.h"
#include "native/attachments/frames/frame_layout.h"
#include "native/attachments/frames/patch.h"

#include <vector>

namespace sinew {

/// The frames of one attached part, each with a patch of the host, and how they are smoothed.
///
/// The more a part bends, the less its anchors differ from the weights of its patches: vertices between two
/// frames follow their tangents, which lie outside of a bend, and the sag of the patches makes up for that.
///
/// Of a sample v beneath frame k, at the gap g_v from the host, the contact weighs
///
///     c_v = phi_k(v) / (1 + (g_v / (g_min + z / 4))^2)^2,     z = 2 rms radius of the samples under phi_k,
///
/// so near points count, and the far side of an eye does not. As an anchor it weighs
/// phi_k(v) max(0, 1 - ((g_v - g_min) / (z / 10))^2)^2. The patch has the radius z / 2 + g_min + 1.5 h with h
/// the host's spacing.
///
/// A cloth over two limbs must not tear: frames are visited along the part, from the one with the least gap
/// g. A frame is trusted if its geodesic distance on the host to every trusted frame u is at most twice that
/// on the part, plus g_k + g_u + 2 h. The frames are smoothed by S = (diag(a) + mu L)^-1 diag(a) with L the
/// Laplacian of the frames of the part, a_k = 0 where a frame is not trusted, and otherwise
/// a_k = 1 / (1 + ((g_k - g_least) / (g_least + length / 4))^2)^2.
struct AttachmentFrames
{
    std::vector<Patch> patches; ///< one per frame, images last
    MatrixX smoothing; ///< (frames, frames), rows sum to 1
    std::vector<Foot> feet; ///< of feet_of(); empty with a single frame
};

/// A single frame of a part that lies on the mirror plane of its host gets the patch and its mirror image, so
/// that the part stays on the plane where both sides of the host move alike.
/// \param layout  its `shares` are not empty.
/// \param tiny    a length that is nothing beside the mesh.
AttachmentFrames make_frames(const Attachment& attachment, const Part& part, const HostSurface& host,
                             const FrameLayout& layout, double tiny);

} // namespace sinew
