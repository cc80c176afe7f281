// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Points and triangles that somebody works on.
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
/// \param offset  the wrap contains the triangles where alpha is not much larger than this.
/// \throw Cancelled  by `progress`, which counts on from 0 towards 1.
TriangleSoup wrapped(const TriangleSoup& target, double alpha, double offset, const Progress& progress);

} // namespace sinew
