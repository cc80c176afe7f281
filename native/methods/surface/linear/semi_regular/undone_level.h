// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/methods/surface/linear/pyramid/ring_frames.h"
#include "native/subdivision/stencils.h"

#include <vector>

namespace sinew {

/// What is wanted of a part of a mesh, and what became of it.
enum class Undoing : char {
    unwanted,  ///< it is left as it is
    wanted,
    small,     ///< left: the coarser level would have too few vertices
    irregular, ///< left: its faces do not come from subdivision
    undone
};

/// One level of subdivision, undone for some parts of a mesh; the others are carried over as they are.
///
/// The faces of a part must be quads that Catmull-Clark's rules give, or triangles that Loop's give. A corner
/// of one face is chosen as a vertex of the coarser level; that decides about all others, face by face:
///
///     quads      each has one kept vertex, across from it a face point, and two edge points between them;
///     triangles  each has one kept vertex and two edge points, or lies in the middle of three edge points.
///
/// It is a subdivision if no vertex gets two roles, edge points have 4 quads or 6 triangles (2 or 3 at a
/// border), face points lie inside, and the coarser faces form a surface again: their corners differ, and
/// no two edges join the same vertices. So vertices of other valences can only be kept. Where several choices
/// are left, as on a torus, the first of these goes first: one that keeps the lowest vertices of the part,
/// because programs that subdivide number those of the control mesh first; one whose coarser faces are all
/// quads; one that keeps the lowest vertex; and the one whose lowest kept vertex is lowest.
struct UndoneLevel
{
    std::vector<int> kept; ///< the vertices of the coarser level, ascending: its vertex k was kept[k]
    std::vector<int> counts, corners; ///< its faces
    SparseRows rule; ///< (n, kept) one step of subdivision, borders as curves; identity where carried over
    std::vector<int> made; ///< the vertices of the parts that are undone
    /// (made) their frames: tangents of the limit surface inside, and of the border and the edges at borders.
    RingFrames frames;
};

/// \param part       (n) the part of each vertex.
/// \param[in,out] undoing  (parts) as `wanted` or `unwanted` at first.
/// \param least      the fewest vertices that an undone part may have.
/// \throw OutOfMemory  the level would take more than limit_memory() allows.
/// Cost: O(n log n) for the edges.
UndoneLevel undo_subdivision(const SurfaceMesh& mesh, const std::vector<int>& part,
                             std::vector<Undoing>& undoing, int least);

} // namespace sinew
