// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/regions.h"
#include "tests/native/methods/surface/linear/dense_operators.h"
#include "tests/native/shapes.h"

#include <map>
#include <utility>
#include <vector>

namespace sinew {

/// The first stage of implicit Laplacian editing once more, with dense matrices. Similarities are fitted to
/// rings by a QR decomposition, with their translations as unknowns.
class DenseImplicit
{
public:
    DenseImplicit(const SurfaceMesh& mesh, Discretization kind);

    const MatrixX& residual() const { return residual_; }

    /// The displacements of rest, with those of the handles turned back by R.
    Points solve(const std::vector<Handle>& handles, const Poses& poses, const Matrix3& R) const;

    /// s and h of each vertex after displacements.
    std::vector<Eigen::Vector4d> fitted(const Points& displacements) const;

private:
    const SurfaceMesh& mesh_;
    int n_;
    MatrixX L_;
    VectorX m_;
    MatrixX residual_;
    std::vector<MatrixX> fits_;
    std::vector<bool> border_;
    std::map<int, std::vector<int>> rings_;
};

} // namespace sinew
