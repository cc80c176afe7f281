// SPDX-License-Identifier: GPL-3.0-or-later
#include "benchmarks/peers/points_peers.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <vector>

void peer_rigid_mls(const double* handles, const double* posed, int handle_count, const double* points,
                    int count, double* result)
{
    using Vector3 = Eigen::Vector3d;
    using Matrix3 = Eigen::Matrix3d;
    const auto at = [](const double* from, int i) { return Vector3(Vector3::Map(from + 3 * i)); };
    std::vector<double> w(handle_count);
    for (int v = 0; v < count; ++v) {
        const Vector3 x = at(points, v);
        Vector3 p_star = Vector3::Zero(), q_star = Vector3::Zero();
        double sum = 0.0;
        for (int i = 0; i < handle_count; ++i) {
            w[i] = 1.0 / (at(handles, i) - x).squaredNorm();
            sum += w[i];
            p_star += w[i] * at(handles, i);
            q_star += w[i] * at(posed, i);
        }
        p_star /= sum;
        q_star /= sum;
        Matrix3 M = Matrix3::Zero();
        for (int i = 0; i < handle_count; ++i)
            M += w[i] * (at(posed, i) - q_star) * (at(handles, i) - p_star).transpose();
        const Eigen::JacobiSVD<Matrix3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Matrix3 U = svd.matrixU();
        if ((U * svd.matrixV().transpose()).determinant() < 0)
            U.col(2) = -U.col(2);
        Vector3::Map(result + 3 * v) = U * svd.matrixV().transpose() * (x - p_star) + q_star;
    }
}
