// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/mesh/trees/box_tree.h"
#include "native/methods/space/lattice/grid/hexahedra_cells.h"
#include "native/methods/space/lattice/grid/placed_points.h"

#include <memory>
#include <vector>

namespace sinew {

/// A lattice of hexahedra of any topology, at rest: where points lie in it.
///
/// Within a cell the map is trilinear. After some steps of subdivision, the cells are small and their map is
/// close to a smooth one. A point outside follows the nearest cell by the affine map that touches its map at
/// the nearest place.
class Hexahedra
{
public:
    /// \param mesh    whose vertices are the corners of hexahedra; faces that are no sides do not count.
    /// \param smooth  steps of subdivision, from 0 to 4.
    /// \throw InvalidMesh    there is no hexahedron, or some are flat or folded, or a vertex is in none;
    ///   these vertices are named.
    /// \throw InvalidOption  `smooth` is out of range.
    Hexahedra(const SurfaceMesh& mesh, int smooth);

    int point_count() const { return mesh_.vertex_count(); }
    int cell_count() const { return static_cast<int>(cells_.size()); }
    double size() const { return size_; }
    /// Vertices that lie on a cell and are no corners of it, where the cells come apart.
    const std::vector<int>& hanging() const { return hanging_; }

    LatticePlace place(const Vector3& point) const;
    /// (cells, 8, 3) the moves of the corners of all cells.
    void moves(PointsView posed, std::vector<double>& moves) const;
    static BlendCell cell(int index, const double* moves);

    bool operator==(const Hexahedra& other) const { return smooth_ == other.smooth_ && mesh_ == other.mesh_; }

private:
    void refuse_folds(const std::vector<Hexahedron>& cells) const;
    void find_hanging();
    void grow_tree();
    Vector3 corner(const Hexahedron& cell, int k) const { return refined_.row(cell[k]).transpose(); }
    Vector3 mapped(const Hexahedron& cell, const Vector3& local, Matrix3& jacobian) const;
    Vector3 nearest_in(const Hexahedron& cell, const Vector3& point, double& distance) const;

    SurfaceMesh mesh_;
    int smooth_;
    std::vector<Hexahedron> cells_; ///< after subdivision
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_;
    Points refined_;
    double size_ = 0.0;
    std::vector<int> hanging_;
    std::unique_ptr<BoxTree> tree_; ///< of the cells
};

} // namespace sinew
