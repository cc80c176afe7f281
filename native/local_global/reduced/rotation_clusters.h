// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <vector>

namespace sinew {

/// The forces with which the rotations of clusters load a surface. Each vertex is in a cluster, and the edges
/// to its neighbours follow the rotation of that cluster:
///
///     F(x, R) = 1/4 sum_ij w_ij |(x_i - x_j) - R_c(i) (p_i - p_j)|^2 = 1/2 <x, L x> - <x, B R> + const
///
/// over ordered pairs of neighbours. The rotations are stacked, three rows per cluster: those of the
/// transposed rotation. So for fixed rotations the points are a solution of L x = B R, and the rotation that
/// fits the points best is the one closest to three rows of B^T x.
struct ClusterLoads
{
    /// \param L       (n, n) of operators/laplacian.h, without negative weights.
    /// \param rest    (n, 3)
    /// \param labels  (n) the cluster of each vertex, or -1 for a vertex that has none.
    ClusterLoads(const SparseMatrix& L, const Points& rest, const std::vector<int>& labels, int clusters);

    Eigen::SparseMatrix<double, Eigen::RowMajor> B; ///< (n, 3 clusters)
    std::vector<Matrix3> own; ///< one per cluster: sum w_ij / 2 (p_i - p_j) (p_i - p_j)^T, which is B^T p
};

/// Rotations or covariances of clusters, three rows each.
using ClusterRows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// The rotations closest to covariances, both transposed. A cluster on one line says nothing about the turn
/// around it, and keeps that of `before`.
/// \param[in,out] S    (3 padded(clusters), 3); rows after those of the clusters are zero.
/// \param before       likewise.
/// \param[out] fitted  likewise; may be `before`.
void fit_clusters(ClusterRows& S, const ClusterRows& before, int clusters, ClusterRows& fitted);
/// A whole number of four clusters, which are fitted together.
inline int padded(int clusters) { return (clusters + 3) / 4 * 4; }

/// A rigid motion in the middle of some poses.
Pose rigid_mean(const Poses& poses);

/// The start of each cluster from the poses alone: the mean of the handles' quaternions by their shares.
/// \param shares  (clusters, handles); the sum of each row is 1.
/// \param middle  the rotation of rigid_mean().
std::vector<Matrix3> mean_rotations(const RowMatrix& shares, const Poses& poses, const Matrix3& middle);

/// An energy in which a surface follows a few rotations, with the points eliminated: what is left has a few
/// tens of unknowns, whatever the size of the mesh.
///
/// O. K.-C. Au, H. Fu, C.-L. Tai, D. Cohen-Or. "Handle-Aware Isolines for Scalable Shape Editing." ACM
/// Transactions on Graphics 26(3), 2007.
///
/// The solution of A x = B R with handles moved by affine maps P is x = X P + Z R. Then
///
///     min_x F = 1/2 <P, K P> - <R, H P> + 1/2 <R, (C - G) R>,    G = B^T Z,  H = B^T X
///
/// with C block diagonal. The rotations are found by turns: S = G R + H P are the covariances of the
/// clusters, and the rotations closest to them are the next R. No turn raises the energy.
class RotationClusters
{
public:
    using Rows = ClusterRows;

    /// \param own  (clusters) the blocks of C.
    /// \param G    (3 clusters, 3 clusters)
    /// \param H    (3 clusters, 4 handles)
    /// \param K    (4 handles, 4 handles)
    RotationClusters(const std::vector<Matrix3>& own, MatrixX G, MatrixX H, MatrixX K);

    int cluster_count() const { return static_cast<int>(own_.rows()) / 3; }
    int handle_count() const { return static_cast<int>(H_.cols()) / 4; }

    /// How handles and clusters move, relative to one rigid motion: where all of them move by it, everything
    /// here is zero, so that no rounding is left.
    struct State
    {
        Pose mean;      ///< that motion
        Rows poses;     ///< (4 handles, 3) P less that motion
        Rows rotations; ///< (3 clusters, 3) R, padded to a whole number of four clusters
        Rows turns;     ///< (3 clusters, 3) R less that motion

        /// R of a cluster.
        Matrix3 rotation(int cluster) const { return rotations.middleRows<3>(3 * cluster).transpose(); }
    };
    struct Settled
    {
        int turns = 0;
        bool converged = false;
        double energy = 0.0;   ///< F
        double residual = 0.0; ///< the relative decrease of F by the last turn
    };

    /// \param poses      (handles) affine maps of the rest points.
    /// \param rotations  (clusters) the start.
    State start(const Poses& poses, const std::vector<Matrix3>& rotations) const;
    /// Turns until no rotation changes by more than `tolerance` (the norm of its matrix), at most `most`
    /// times.
    Settled settle(State& state, int most, double tolerance) const;
    /// F of the points that belong to the rotations of a state.
    double energy(const State& state) const { return energy(state.poses, state.turns); }

private:
    double energy(const Rows& poses, const Rows& turns) const;

    Rows own_; ///< (3 clusters, 3)
    MatrixX G_, H_, K_;
};

} // namespace sinew
