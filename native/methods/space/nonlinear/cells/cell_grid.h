// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/space/weights/blended_maps.h"

#include <array>
#include <vector>

namespace sinew {

class Voxels;

/// A cube of the octree that belongs to the shape.
struct Cell
{
    Vector3 centre;
    double half; ///< of its side
};

/// Where two cells touch: the whole side of the smaller one.
struct CellFace
{
    int cell[2];
    double half; ///< of the side
    Vector3 middle;
    int axis;    ///< across the face; -1 for a link between cells that do not touch
};

/// The cubes that a shape fills, from a graded octree: cubes of the finest level that a face or a point of it
/// touches, and inside of closed surfaces ever larger ones, such that neighbours differ by one level at most.
///
/// Cells that touch are linked where a face of the shape runs through both, where the middle of their common
/// side lies inside of the shape, or where they have different parts of it. So limbs stay apart if they are
/// in different cells, but parts that lie on each other hold together.
class CellGrid
{
public:
    /// \param mesh    of any faces, also open ones or none.
    /// \param wanted  about how many cells.
    /// \param levels  how many levels larger cells may be inside; 0 for cells of one size.
    CellGrid(const SurfaceMesh& mesh, int wanted, int levels, const Progress& progress);

    const std::vector<Cell>& cells() const { return cells_; }
    const std::vector<CellFace>& faces() const { return faces_; }
    int size() const { return static_cast<int>(cells_.size()); }
    double side() const { return side_; } ///< of the finest cells
    /// The cell that has a point, or the nearest one; and whether it has.
    int cell_at(const Vector3& point, bool* inside = nullptr) const;

    /// Links each piece of cells none of which is in `held` to the cell nearest to it in another piece, if
    /// that is near, see are_near(), or has no faces, as points of curves. Returns the cells of pieces that
    /// remain without one that is held.
    std::vector<int> join_loose_pieces(const std::vector<char>& held);

    /// The cells that each of some points follows: those whose centres are nearer, along each axis, than
    /// their side, by the product of 1 - 3 r^2 + 2 r^3 over the axes, with r the distance in sides. So what
    /// follows is smooth. Cells that are not close to the point's own one along the links do not count.
    std::vector<std::vector<BlendedMaps::Share>> shares(PointsView points, std::vector<int>& outside) const;

private:
    void make_cells(const Voxels& voxels);
    void link(const SurfaceMesh& mesh, const Voxels& voxels);
    int id(const std::array<int, 3>& voxel) const;
    std::array<int, 3> voxel_of(const Vector3& point) const;
    Vector3 nearest_in(int cell, const Vector3& point) const;
    std::vector<int> pieces() const;
    bool join_to_next(const std::vector<int>& piece, int loose);

    Vector3 origin_ = Vector3::Zero();
    double side_ = 1.0; ///< of the finest cells
    std::array<int, 3> dims_{};
    int levels_ = 0;
    bool has_faces_ = true;
    std::vector<int> ids_; ///< the cell of each voxel, or -1
    std::vector<Cell> cells_;
    std::vector<int> level_of_; ///< of each cell
    std::vector<CellFace> faces_;
};

} // namespace sinew
