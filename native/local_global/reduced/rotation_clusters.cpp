// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/reduced/rotation_clusters.h"

#include "native/core/simd/kernel_set.h"
#include "native/local_global/arap/cell_fits.h"
#include "native/operators/fits/fit_kernels.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

constexpr int four = 4; ///< rotations are fitted four at a time
constexpr int numbers = 9;

using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

Block block(RotationClusters::Rows& rows, int cluster)
{
    return Block(rows.data() + numbers * static_cast<std::size_t>(cluster));
}

} // namespace

ClusterLoads::ClusterLoads(const SparseMatrix& L, const Points& rest, const std::vector<int>& labels,
                           int clusters)
    : B(L.rows(), 3 * clusters), own(clusters, Matrix3::Zero())
{
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < L.cols(); ++i)
        for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
            const int j = static_cast<int>(it.row());
            if (j == i || labels[i] < 0 || labels[j] < 0)
                continue;
            const Vector3 edge = (rest.row(i) - rest.row(j)).transpose();
            const Vector3 half = -0.5 * it.value() * edge;
            own[labels[i]] += half * edge.transpose();
            for (const int cluster : {labels[i], labels[j]})
                for (int axis = 0; axis < 3; ++axis)
                    entries.emplace_back(i, 3 * cluster + axis, half[axis]);
        }
    B.setFromTriplets(entries.begin(), entries.end());
}

void fit_clusters(ClusterRows& S, const ClusterRows& before, int clusters, ClusterRows& fitted)
{
    const FitKernels& kernels = widest_kernels<FitKernels>();
    for (int k = 0; k < clusters; ++k)
        block(S, k) += tie * block(S, k).norm() * before.middleRows<3>(3 * static_cast<Eigen::Index>(k));
    for (int k = 0; k < clusters; k += four) {
        const int safe = kernels.fit(block(S, k).data(), block(fitted, k).data());
        for (int i = k; i < std::min(k + four, clusters); ++i)
            if (!(safe >> (i - k) & 1))
                block(fitted, i) = fit_rotation_svd(block(S, i));
    }
}

Pose rigid_mean(const Poses& poses)
{
    Matrix3 linear = Matrix3::Zero();
    Vector3 move = Vector3::Zero();
    for (const Pose& pose : poses) {
        linear += fit_rotation(pose.leftCols<3>());
        move += pose.col(3);
    }
    Pose mean;
    mean << fit_rotation(linear), move / static_cast<double>(poses.size());
    return mean;
}

std::vector<Matrix3> mean_rotations(const RowMatrix& shares, const Poses& poses, const Matrix3& middle)
{
    const Eigen::Quaterniond mean(middle);
    const auto handles = static_cast<Eigen::Index>(poses.size());
    Eigen::MatrixX4d apart(handles, 4); // so that no rounding is left where all of them are one
    for (Eigen::Index h = 0; h < handles; ++h) {
        const Eigen::Quaterniond q(fit_rotation(poses[h].leftCols<3>()));
        apart.row(h) = ((q.dot(mean) < 0 ? -1.0 : 1.0) * q.coeffs() - mean.coeffs()).transpose();
    }
    std::vector<Matrix3> rotations;
    for (Eigen::Index k = 0; k < shares.rows(); ++k) {
        const Eigen::Vector4d sum = mean.coeffs() + (shares.row(k) * apart).transpose();
        rotations.push_back(sum.norm() > 1e-9 ? Eigen::Quaterniond(sum.normalized()).toRotationMatrix()
                                              : middle);
    }
    return rotations;
}

RotationClusters::RotationClusters(const std::vector<Matrix3>& own, MatrixX G, MatrixX H, MatrixX K)
    : own_(3 * own.size(), 3), G_(std::move(G)), H_(std::move(H)), K_(std::move(K))
{
    for (int k = 0; k < static_cast<int>(own.size()); ++k)
        block(own_, k) = own[k];
}

RotationClusters::State RotationClusters::start(const Poses& poses,
                                                const std::vector<Matrix3>& rotations) const
{
    State state;
    const Pose mean = rigid_mean(poses);
    state.mean = mean;
    state.poses.resize(4 * static_cast<Eigen::Index>(poses.size()), 3);
    for (std::size_t h = 0; h < poses.size(); ++h)
        state.poses.middleRows<4>(4 * static_cast<Eigen::Index>(h)) = (poses[h] - mean).transpose();
    const int count = cluster_count();
    state.rotations = Rows::Zero(3 * static_cast<Eigen::Index>(padded(count)), 3);
    state.turns.resize(3 * static_cast<Eigen::Index>(count), 3);
    for (int k = 0; k < count; ++k) {
        block(state.rotations, k) = rotations[k].transpose();
        block(state.turns, k) = (rotations[k] - mean.leftCols<3>()).transpose();
    }
    return state;
}

RotationClusters::Settled RotationClusters::settle(State& state, int most, double tolerance) const
{
    const int count = cluster_count();
    const Matrix3 mean = state.mean.leftCols<3>().transpose();
    const Rows fixed = own_ * mean + H_ * state.poses;
    Rows S = Rows::Zero(state.rotations.rows(), 3), fitted(S.rows(), 3);
    Settled settled;
    Rows before;
    while (!settled.converged && settled.turns < most) {
        S.topRows(fixed.rows()).noalias() = G_ * state.turns;
        S.topRows(fixed.rows()) += fixed;
        fit_clusters(S, state.rotations, count, fitted);
        double change = 0.0;
        for (int k = 0; k < count; ++k)
            change = std::max(change, (block(fitted, k) - block(state.rotations, k)).norm());
        state.rotations.topRows(fixed.rows()) = fitted.topRows(fixed.rows());
        before = state.turns;
        for (int k = 0; k < count; ++k)
            block(state.turns, k) = block(fitted, k) - mean;
        ++settled.turns;
        settled.converged = change <= tolerance;
    }
    settled.energy = energy(state);
    if (settled.turns > 0)
        if (const double last = energy(state.poses, before); last > 0)
            settled.residual = std::max(0.0, 1.0 - settled.energy / last);
    return settled;
}

double RotationClusters::energy(const Rows& poses, const Rows& turns) const
{
    double twice = poses.cwiseProduct(K_ * poses).sum() - 2 * turns.cwiseProduct(H_ * poses).sum() -
                   turns.cwiseProduct(G_ * turns).sum();
    for (int k = 0; k < cluster_count(); ++k) {
        const auto turn = turns.middleRows<3>(3 * k);
        twice += turn.cwiseProduct(own_.middleRows<3>(3 * k) * turn).sum();
    }
    return std::max(0.0, 0.5 * twice);
}

} // namespace sinew
