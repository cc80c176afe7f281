// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/cage/cage.h"
#include "native/solvers/spd_factor.h"

#include <vector>

namespace sinew {

/// The stretched normals of a smooth cage's faces, by three columns per control point.
///
/// They are not linear in the control points. But s n' = A n, with a matrix A that is the same for all faces
/// if the cage is turned and scaled, and that varies little from face to face otherwise. So let A be bilinear
/// on each face of the cage as it was given, with a matrix A_k at each control point k:
///
///     s_t n'_t ~ sum_k b_k(t) A_k n_t
///
/// In every frame the A_k are those that fit all stretched normals best, weighted by the areas of the faces:
/// least squares, with one matrix that is factorised once. The columns of the A_k are the controls. Where the
/// surface is flat, normals do not determine A_k; there it is drawn, by `slack` of the mean diagonal of the
/// matrix, to the affine map that fits the motion of all control points best.
class SmoothNormals
{
public:
    /// One of the columns that Green coordinates have behind the vertices of the cage.
    struct Column
    {
        int face;          ///< of cage.rest()
        Vector3 rest;      ///< the normalised normal at rest, or a part of it
        double weight = 0; ///< area for which this column fits, where rest is a normal; 0 for other parts
    };

    /// \param columns  all of them, in their order.
    SmoothNormals(const Cage& cage, const std::vector<Column>& columns);

    int columns() const { return static_cast<int>(of_columns_.cols()); }
    /// Takes the columns behind the control points to weights of the A_k.
    void fold(RowMatrix& rows) const;
    /// \param normals  (columns, 3) the stretched normals of a pose, and parts of them.
    /// \param[out] controls  (3 * control points, 3) the columns of A_k.
    void controls(const Points& normals, PointsView control, Eigen::Ref<Points> controls) const;

private:
    SparseRows of_columns_; ///< (columns, 3 * control points) what each column at rest is of the A_k
    std::vector<double> weights_;
    Points rest_; ///< (columns, 3)
    Points pseudo_inverse_; ///< (control points, 3) gives the affine map that fits best
    SpdFactor factor_;
};

} // namespace sinew
