// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/subdivision/stencils.h"

#include <array>
#include <vector>

namespace sinew {

enum class SubdivisionScheme {
    catmull_clark, ///< any polygons; Catmull & Clark 1978
    loop,          ///< triangles alone; Loop 1987
    bilinear,      ///< faces are split, nothing is smoothed: what Blender calls simple
};

/// What happens at the corners of an open border.
enum class BoundarySmooth { all, preserve_corners };

/// Which borders of a face-varying channel stay as they are, from all to none.
enum class UvSmooth {
    none,
    preserve_corners,
    preserve_corners_and_junctions,
    preserve_corners_junctions_and_concave,
    preserve_boundaries,
    smooth_all,
};

struct SubdivisionOptions
{
    SubdivisionScheme scheme = SubdivisionScheme::catmull_clark;
    int level = 2;      ///< how often the faces are split, 0 to 10
    bool limit = false; ///< the refined vertices lie where endless subdivision takes them
    BoundarySmooth boundary_smooth = BoundarySmooth::all;
    UvSmooth uv_smooth = UvSmooth::preserve_boundaries;

    /// Creased edges and sharp vertices. A sharpness of s is sharp for s levels and smooth after them; from
    /// 10 on, for ever. Blender's creases c in [0, 1] are the sharpness 10 c^2.
    std::vector<std::array<int, 2>> crease_edges;
    std::vector<double> crease_sharpness; ///< (edges), >= 0
    std::vector<int> corner_vertices;
    std::vector<double> corner_sharpness; ///< (vertices), >= 0

    /// The value of a face-varying channel (UVs) at each face corner, by index, face after face; empty for
    /// none.
    std::vector<int> face_varying;
};

/// A mesh refined by OpenSubdiv: every refined point is a weighted sum of the control points.
///
/// E. Catmull, J. Clark. "Recursively Generated B-Spline Surfaces on Arbitrary Topological Meshes."
/// Computer-Aided Design 10(6), 1978, pp. 350-355. C. Loop. "Smooth Subdivision Surfaces Based on Triangles."
/// University of Utah, 1987. Creases: T. DeRose, M. Kass, T. Truong. "Subdivision Surfaces in Character
/// Animation." SIGGRAPH 1998.
///
/// The same library with the same options as Blender's Subdivision modifier, in another order: the first
/// vertices are those of the mesh, then come those that each level adds. Edges of three and more faces, and
/// edges along which both faces run the same way, are sharp; loose vertices stay. Limits are exact also where
/// sharpness is left after the last level, and at the ends of creases (limit_masks.h).
///
///   call           repeat it when ...              cost
///   constructor    the faces or options changed    O(refined vertices): about 1 us each
///   refine()       the points moved                one pass over the weights: about 16 a refined vertex
class SubdivisionSurface
{
public:
    /// \throw InvalidMesh    `loop` and a face that is no triangle; a face with a corner twice; a vertex or
    /// face of
    ///                       more than 65535 edges.
    /// \throw InvalidOption  a level outside [0, 10]; as many sharpnesses as edges or vertices are needed, >=
    /// 0;
    ///                       an edge that the mesh has not; a vertex out of range; face_varying of another
    ///                       length, or below 0.
    /// \throw OutOfMemory    the refined mesh would take more than limit_memory() allows, or has 2^31
    /// corners.
    explicit SubdivisionSurface(const SurfaceMesh& mesh, const SubdivisionOptions& options = {});

    int control_count() const { return static_cast<int>(stencils_.matrix().cols()); }
    int vertex_count() const { return static_cast<int>(stencils_.matrix().rows()); }

    /// \param points   (control_count, 3) at rest or deformed
    /// \param refined  (vertex_count, 3)
    void refine(const double* points, double* refined) const { stencils_.apply(points, refined); }
    void refine(const float* points, float* refined) const { stencils_.apply(points, refined); }
    /// (vertex_count, control_count); rows sum to 1.
    const SparseRows& matrix() const { return stencils_.matrix(); }

    /// Corners of each refined face, and their vertices face after face. From level 1 on, all faces have four
    /// corners, or three with `loop`. Faces of one control face follow one another.
    const std::vector<int>& face_counts() const { return counts_; }
    const std::vector<int>& face_corners() const { return corners_; }

    /// Unit normals at refined points: the mean of the refined faces around each, by area.
    /// \param refined  (vertex_count, 3)
    Points normals(PointsView refined) const;

    /// (refined values, values) of the face-varying channel, and the value at each refined face corner. Empty
    /// without a channel.
    const SparseRows& face_varying_matrix() const { return face_varying_; }
    const std::vector<int>& face_varying_corners() const { return face_varying_corners_; }

private:
    Stencils stencils_;
    SparseRows face_varying_;
    std::vector<int> counts_, corners_, face_varying_corners_;
    std::vector<int> around_offsets_, around_; ///< the refined faces at each refined vertex, ascending
};

} // namespace sinew
