// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <numbers>

namespace sinew {

struct CurvatureLengthOptions
{
    double tolerance = 0.0; ///< how far triangles may be from the surface; 0: a thousandth of its size
    double shortest = 0.0;  ///< 0: twice the tolerance
    double longest = 0.0;   ///< 0: a tenth of the size
    double angle = std::numbers::pi / 4; ///< radians, in (0, pi]; folds that are sharper do not count as bent
};

/// How long the edges at each vertex may be so that triangles stay so close to the surface, for remesh().
///
/// M. Dunyach, D. Vanderhaeghe, L. Barthe, M. Botsch. "Adaptive Remeshing for Real-Time Mesh Deformation."
/// Eurographics 2013 (short papers), section 2: an equilateral triangle whose corners lie on a sphere of
/// curvature k has its middle e below the sphere where its sides are
///
///     L = sqrt(6 e / k - 3 e^2)
///
/// Here k is the largest principal curvature, by amount, on either side of a fold, or that of the border or
/// fold itself. As remeshing splits edges from 4/3 of their length on, it gets 3/4 of this. The length rises by
/// at most half of the way along an edge, so that triangles keep their shape.
///
/// The size of a surface is the diagonal of its box. Vertices without faces get the longest length.
/// Cost: O(n log n), most of it for curvature().
///
/// \return  (n), from `shortest` to `longest`.
/// \throw InvalidOption  a negative length, a shortest one above the longest one, an angle out of range.
/// \throw InvalidMesh    no face has an area.
VectorX lengths_by_curvature(const SurfaceMesh& mesh, const CurvatureLengthOptions& options = {});

} // namespace sinew
