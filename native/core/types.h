// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <vector>

namespace sinew {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
using MatrixX = Eigen::MatrixXd;
/// A matrix that is stored one row after the other.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// (n, 3) points, one per row: NumPy's order, so that arrays enter without a copy.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// Points in memory that somebody else owns, for example NumPy.
using PointsView = Eigen::Map<const Points>;

inline PointsView view(const Points& points) { return {points.data(), points.rows(), 3}; }

/// (3, 4) affine map of column points, x -> A x + t, in the target's object space.
using Pose = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
using Poses = std::vector<Pose>;

/// Column-major with 32-bit indices, which CHOLMOD reads without a copy.
using SparseMatrix = Eigen::SparseMatrix<double>;

inline Vector3 apply(const Pose& pose, const Vector3& point)
{
    return pose.leftCols<3>() * point + pose.col(3);
}

} // namespace sinew
