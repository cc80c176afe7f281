// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/subdivision/stencils.h"

#include <array>
#include <span>
#include <vector>

namespace sinew {

enum class SubdivisionScheme {
    catmull_clark, ///< any polygons; Catmull & Clark 1978
    loop,          ///< only triangles; Loop 1987
    bilinear,      ///< splits faces without smoothing them; Blender calls it simple
};
constexpr auto choices(SubdivisionScheme)
{
    return std::array{Choice{"catmull_clark", SubdivisionScheme::catmull_clark},
                      Choice{"loop", SubdivisionScheme::loop},
                      Choice{"bilinear", SubdivisionScheme::bilinear}};
}

/// What happens at the corners of an open border.
enum class BoundarySmooth { all, preserve_corners };
constexpr auto choices(BoundarySmooth)
{
    return std::array{Choice{"all", BoundarySmooth::all},
                      Choice{"preserve_corners", BoundarySmooth::preserve_corners}};
}

/// Which borders of a face-varying channel stay as they are, from all to none.
enum class UvSmooth {
    none,
    preserve_corners,
    preserve_corners_and_junctions,
    preserve_corners_junctions_and_concave,
    preserve_boundaries,
    smooth_all,
};
constexpr auto choices(UvSmooth)
{
    return std::array{
        Choice{"none", UvSmooth::none},
        Choice{"preserve_corners", UvSmooth::preserve_corners},
        Choice{"preserve_corners_and_junctions", UvSmooth::preserve_corners_and_junctions},
        Choice{"preserve_corners_junctions_and_concave", UvSmooth::preserve_corners_junctions_and_concave},
        Choice{"preserve_boundaries", UvSmooth::preserve_boundaries},
        Choice{"smooth_all", UvSmooth::smooth_all}};
}

struct SubdivisionOptions
{
    SubdivisionScheme scheme = SubdivisionScheme::catmull_clark;
    int level = 2;      ///< how many times the faces are split, 0 to 10
    bool limit = false; ///< whether to move the refined vertices to the limit of endless subdivision
    BoundarySmooth boundary_smooth = BoundarySmooth::all;
    UvSmooth uv_smooth = UvSmooth::preserve_boundaries;

    /// Creased edges and sharp vertices. An edge of sharpness s is sharp for s levels and smooth after them;
    /// from 10 on, it is sharp on all levels. A crease c of Blender, in [0, 1], is the sharpness 10 c^2.
    std::vector<std::array<int, 2>> crease_edges;
    std::vector<double> crease_sharpness; ///< (edges), >= 0
    std::vector<int> corner_vertices;
    std::vector<double> corner_sharpness; ///< (vertices), >= 0

    /// The index of the value that a face-varying channel (UVs) has at each face corner, face after face.
    /// Empty where there is no such channel.
    std::vector<int> face_varying;
};

/// A mesh refined by OpenSubdiv: every refined point is a weighted sum of the control points.
///
/// E. Catmull, J. Clark. "Recursively Generated B-Spline Surfaces on Arbitrary Topological Meshes."
/// Computer-Aided Design 10(6), 1978, pp. 350-355. C. Loop. "Smooth Subdivision Surfaces Based on Triangles."
/// University of Utah, 1987. Creases: T. DeRose, M. Kass, T. Truong. "Subdivision Surfaces in Character
/// Animation." SIGGRAPH 1998.
///
/// Blender's Subdivision modifier uses the same library with the same options. Here the order of the refined
/// vertices is another one: first those of the mesh, then those that each level adds. Edges of three or more
/// faces, and edges along which both faces run the same way, are sharp; loose vertices keep their place.
/// Limits are exact also where sharpness is left after the last level, and at the ends of creases
/// (limit_masks.h).
///
///   call           repeat it when ...              cost
///   constructor    the faces or options changed    O(refined vertices): about 1 us each
///   refine()       the points moved                one pass over the weights: about 16 per refined vertex
class SubdivisionSurface
{
public:
    /// \throw InvalidMesh  with `loop`, a face is no triangle; a face has a corner twice; a vertex or face
    ///   has more than 65535 edges.
    /// \throw InvalidOption  the level is outside [0, 10]; there is another number of sharpnesses than of
    ///   edges or vertices, or one is below 0; the mesh does not have one of the edges or vertices;
    ///   face_varying has another length, or an index below 0.
    /// \throw OutOfMemory  the refined mesh would take more than limit_memory() allows, or have 2^31
    ///   corners.
    explicit SubdivisionSurface(const SurfaceMesh& mesh, const SubdivisionOptions& options = {});

    /// The same surface, whose vertex k is what was vertex order[k]: such as in the order of another program.
    /// Refining costs as much as before.
    /// \throw InvalidOption  `order` does not name each vertex once.
    SubdivisionSurface reordered(std::span<const int> order) const;

    int control_count() const { return static_cast<int>(stencils_.matrix().cols()); }
    int vertex_count() const { return static_cast<int>(stencils_.matrix().rows()); }

    /// \param points   (control_count, 3) the control points, at rest or deformed
    /// \param refined  (vertex_count, 3)
    void refine(const double* points, double* refined) const { stencils_.apply(points, refined); }
    void refine(const float* points, float* refined) const { stencils_.apply(points, refined); }
    /// (vertex_count, control_count); rows sum to 1.
    const SparseRows& matrix() const { return stencils_.matrix(); }

    /// The number of corners of each refined face, and the vertices at them, face after face. From level 1
    /// on, all faces have four corners, or three with `loop`. The parts of one control face follow one
    /// another.
    const std::vector<int>& face_counts() const { return counts_; }
    const std::vector<int>& face_corners() const { return corners_; }

    /// Unit normals at the refined points: the means of the normals of the refined faces around each point,
    /// weighted by area.
    /// \param refined  (vertex_count, 3)
    Points normals(PointsView refined) const;

    /// (refined values, values) the weights of the face-varying channel, and the index of the refined value
    /// at each refined face corner. Empty without a channel.
    const SparseRows& face_varying_matrix() const { return face_varying_; }
    const std::vector<int>& face_varying_corners() const { return face_varying_corners_; }

private:
    void find_faces_around();

    Stencils stencils_;
    SparseRows face_varying_;
    std::vector<int> counts_, corners_, face_varying_corners_;
    std::vector<int> around_offsets_, around_; ///< the refined faces at each refined vertex, ascending
};

} // namespace sinew
