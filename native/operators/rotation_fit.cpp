// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/rotation_fit.h"

#include <Eigen/SVD>

#include <cmath>

namespace sinew {

namespace {

/// Below this slope of the characteristic polynomial (S scaled to |S| = 1) the largest
/// eigenvalue is treated as double: the quaternion's error grows as epsilon / slope.
constexpr double least_slope = 1e-3;

double minor3(const Eigen::Matrix4d& m, int r, int c)
{
    static constexpr int others[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
    const int* i = others[r];
    const int* j = others[c];
    return m(i[0], j[0]) * (m(i[1], j[1]) * m(i[2], j[2]) - m(i[1], j[2]) * m(i[2], j[1])) -
           m(i[0], j[1]) * (m(i[1], j[0]) * m(i[2], j[2]) - m(i[1], j[2]) * m(i[2], j[0])) +
           m(i[0], j[2]) * (m(i[1], j[0]) * m(i[2], j[1]) - m(i[1], j[1]) * m(i[2], j[0]));
}

} // namespace

Matrix3 fit_rotation_svd(const Matrix3& S)
{
    const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 U = svd.matrixU();
    const Matrix3& V = svd.matrixV();
    if ((U * V.transpose()).determinant() < 0)
        U.col(2) = -U.col(2);
    return U * V.transpose();
}

Eigen::Quaterniond fit_rotation_quaternion(const Matrix3& S)
{
    const double size = S.norm();
    if (!(size > 1e-150))
        return Eigen::Quaterniond::Identity();
    const Matrix3 A = S / size;

    Eigen::Matrix4d K;
    const double a = A(0, 0), b = A(1, 1), c = A(2, 2);
    K(0, 0) = a + b + c;
    K(1, 1) = a - b - c;
    K(2, 2) = b - a - c;
    K(3, 3) = c - a - b;
    K(0, 1) = K(1, 0) = A(2, 1) - A(1, 2);
    K(0, 2) = K(2, 0) = A(0, 2) - A(2, 0);
    K(0, 3) = K(3, 0) = A(1, 0) - A(0, 1);
    K(1, 2) = K(2, 1) = A(0, 1) + A(1, 0);
    K(1, 3) = K(3, 1) = A(0, 2) + A(2, 0);
    K(2, 3) = K(3, 2) = A(1, 2) + A(2, 1);

    // det(K - l I) = l^4 - 2 l^2 + c1 l + c0 for |A| = 1; its largest root is at most sqrt(3),
    // and Newton from there falls onto it without overshooting.
    const double c1 = -8 * A.determinant();
    const double c0 = K.determinant();
    double l = std::sqrt(3.0);
    double slope = 0.0;
    for (int step = 0; step < 50; ++step) {
        const double square = l * l;
        slope = 4 * l * square - 4 * l + c1;
        if (slope < least_slope)
            return Eigen::Quaterniond(fit_rotation_svd(S));
        const double move = (square * square - 2 * square + c1 * l + c0) / slope;
        l -= move;
        if (std::abs(move) < 1e-15)
            break;
    }

    // Every non-zero column of the adjugate of K - l I is the eigenvector; the one with the
    // largest diagonal entry is the best conditioned.
    K.diagonal().array() -= l;
    int best = 0;
    double most = -1.0;
    for (int r = 0; r < 4; ++r) {
        const double diagonal = std::abs(minor3(K, r, r));
        if (diagonal > most) {
            most = diagonal;
            best = r;
        }
    }
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k)
        q[k] = ((best + k) & 1) ? -minor3(K, best, k) : minor3(K, best, k);
    q.normalize();
    return {q[0], q[1], q[2], q[3]};
}

Matrix3 rotation_from_vector(const Vector3& omega)
{
    const double angle = omega.norm();
    return angle < 1e-14 ? Matrix3::Identity() : Eigen::AngleAxisd(angle, omega / angle).toRotationMatrix();
}

} // namespace sinew
