// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/skeleton/skeleton.h"

#include <vector>

namespace sinew {

/// The vertices that each bone holds: the rigid middle of its limb.
///
/// A vertex starts as one of the bone that the smallest ball reaches which touches the surface there from
/// inside: a bone outside of the limb is reached by none. It has to be about as far from the bone as the
/// surface is where it is thinnest. From these vertices, distances along the surface decide which bone every
/// vertex belongs to. So the vertices of a leg do not belong to the other leg, however near that is. Of its
/// vertices, a bone holds those beside its length: not those within `margin` of its length from a joint, so
/// that joints can bend.
///
/// \param margin  in [0, 0.5): as a share of the length of a bone.
/// \return (bones) vertices in rising order; a bone outside of the mesh, or inside of another one's limb, has
///   none.
/// \throw InvalidOption  the margin is outside of its range.
std::vector<std::vector<int>> bone_regions(const SurfaceMesh& mesh, const Skeleton& skeleton,
                                           double margin = 0.25);

} // namespace sinew
