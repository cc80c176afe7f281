// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Points, and triangles that name them by index.
struct TriangleSoup
{
    std::vector<Vector3> points;
    std::vector<Triangle> triangles;
};

/// A closed, embedded surface around any triangles, at about `offset` from them.
///
/// C. Portaneri et al. "Alpha Wrapping with an Offset." ACM Transactions on Graphics 41(4), 2022, by CGAL.
///
/// \param alpha   openings narrower than this are closed.
/// \param offset  the wrap contains the triangles if alpha is not much larger than this.
/// \throw Cancelled  by `progress`. Its fraction approaches 1, as the number of steps is not known before.
TriangleSoup wrapped(const TriangleSoup& target, double alpha, double offset, const Progress& progress);

} // namespace sinew
