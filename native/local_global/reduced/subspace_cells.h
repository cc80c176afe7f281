// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/dense.h"
#include "native/core/types.h"
#include "native/local_global/reduced/rotation_clusters.h"
#include "native/mesh/frames/enclosed_volume.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// The energy of a surface x = B y with few unknowns y, whose clusters of vertices follow one rotation each:
///
///     F(y, R) = 1/4 sum_ij w_ij |x_i - x_j - R_c(i) (x_i - x_j)^0|^2
///             + 1/2 sum_i b / m_i |(L x)_i - R_c(i) (L x)_i^0|^2
///             + 1/2 sum_i s_i |x_i - t_i|^2 + e / 2 |y - M y^0|^2
///
/// over ordered pairs of neighbours, with (...)^0 that of the base shape B y^0. All of it is kept as matrices
/// of the size of y, one per cluster and one per handle: W_k = sum of the rows of cluster k, squared. So an
/// evaluation never touches the surface, and another base shape needs no pass over it either. The rows of B
/// sum to 1. M is a rigid motion, and the last term, with e = 1e-5 of the mean diagonal of sum W_k, decides
/// where the surface leaves a combination of the unknowns open, as a flat one in a symmetric cage does: a
/// smaller e would let rounding choose there, and a larger one would be seen.
class SubspaceCells
{
public:
    using Rows = RotationClusters::Rows;

    struct Pull
    {
        int handle;
        int vertex;
        double stiffness; ///< s_i > 0
    };

    /// \param B          (n, c)
    /// \param L, mass    of operators/laplacian.h; without negative weights.
    /// \param labels     (n) the cluster of each vertex.
    /// \param curvature  b
    /// \param pulls      at least one; targets are affine images of the base shape, one map per handle.
    /// \throw FactorizationFailed
    SubspaceCells(const RowMatrix& B, const SparseMatrix& L, const VectorX& mass,
                  const std::vector<int>& labels, int clusters, double curvature,
                  const std::vector<Pull>& pulls, int handles);

    int unknown_count() const { return static_cast<int>(A_.rows()); }
    int cluster_count() const { return static_cast<int>(stiffness_.size()); }
    double anchor() const { return anchor_; } ///< e
    std::int64_t bytes() const;

    /// What depends on the base shape.
    struct Base
    {
        Points y;     ///< (c, 3) y^0
        MatrixX z;    ///< (c, 3 clusters) W_k y^0
        Rows own;     ///< (3 clusters, 3) y^0^T W_k y^0
    };
    Base base(const Points& y) const;

private:
    friend class SubspaceProblem;

    std::vector<MatrixX> stiffness_; ///< W_k
    std::vector<MatrixX> pulls_;     ///< one per handle
    double anchor_ = 0.0;            ///< e
    MatrixX A_;
    CholeskyFactor factor_;
};

/// A volume that is to be kept, of a coarse surface whose points are those of the subspace: B y.
struct CoarseVolume
{
    RowMatrix B; ///< (m, c)
    EnclosedVolume volume;
};

/// F as a function of u = y - M y^0, with rotations that are fitted to every u. With a volume, points are
/// admitted onto that of the base shape by steps along A^-1 times its gradient, and gradients are projected
/// in the same metric.
///
/// J. Huang et al. "Subspace Gradient Domain Mesh Deformation." SIGGRAPH 2006, which keeps the volume by a
/// Lagrange multiplier.
class SubspaceProblem final : public MetricProblem
{
public:
    /// \param mean     M
    /// \param targets  (handles) where each handle wants all unknowns, less M y^0: (c, 3)
    /// \param coarse   null where no volume is kept
    /// \param shape    (m, 3) the coarse points of the base shape, moved by M; only read with `coarse`.
    SubspaceProblem(const SubspaceCells& cells, const SubspaceCells::Base& base, const Pose& mean,
                    const std::vector<Points>& targets, const CoarseVolume* coarse = nullptr,
                    const Points& shape = {});

    void set_rotation(int cluster, const Matrix3& R);
    Matrix3 rotation(int cluster) const { return rotations_.middleRows<3>(3 * cluster).transpose(); }
    /// R less that of M, of all clusters, transposed: (3 clusters, 3).
    const SubspaceCells::Rows& turns() const { return turns_; }

    /// (c, 3) the u that minimises F for the present rotations, admitted.
    Points unknowns_for_rotations();
    /// (c, 3) A^-1 times the gradient of the coarse volume at the last admitted u.
    const Points& volume_direction() const { return direction_; }

    double evaluate(const Points& u, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override {}
    void restore_state() override {}
    bool admit(Points& u) override;

private:
    double measure(const Points& u);

    const SubspaceCells& cells_;
    const SubspaceCells::Base& base_;
    const CoarseVolume* coarse_;
    const Points& shape_;
    Matrix3 mean_; ///< transposed
    Points forces_; ///< sum of the pulls' matrices times targets
    double constant_ = 0.0;
    SubspaceCells::Rows rotations_, turns_, fixed_, fits_;
    double wanted_ = 0.0;
    Points normal_, direction_; ///< the gradient of the volume, and A^-1 times it
    Points coarse_points_, coarse_gradient_;
};

} // namespace sinew
