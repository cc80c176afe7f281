// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

namespace sinew {

/// \throw InvalidMesh  the target has another number of vertices or faces than the source, or faces with
///   other vertices; these are named.
void require_same_faces(const SurfaceMesh& source, const SurfaceMesh& target);

} // namespace sinew
