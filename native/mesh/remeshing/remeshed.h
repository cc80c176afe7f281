// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/remeshing/manifold.h"
#include "native/mesh/remeshing/origins.h"

#include <array>
#include <vector>

namespace sinew {

/// New triangles for a surface.
struct Remeshed
{
    std::vector<Vector3> points;
    std::vector<Triangle> triangles;
    std::vector<Edge> lines;  ///< edges of the new surface that lie on given ones
    std::vector<int> sources; ///< (lines) which of the given ones
    Origins origins;
    double length = 0.0; ///< that edges were to have; 0 where none was
};

/// Joins the vertices at which a mesh was cut, where copies of them are still in one place.
///
/// \param remeshed  points, triangles, and in `lines` its edges on lines of any kind.
/// \param cut       what it was made of.
void join_cuts(Remeshed& remeshed, const SurfaceMesh& mesh, const Manifold& cut);

/// Keeps of the lines those on given ones, and finds where everything comes from.
void trace(Remeshed& remeshed, const SurfaceMesh& mesh, const Manifold& cut, const std::vector<Edge>& given,
           const Progress& progress);

} // namespace sinew
