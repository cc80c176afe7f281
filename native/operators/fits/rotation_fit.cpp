// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include "native/operators/fits/rotation_fit.inl"

namespace sinew {

Matrix3 fit_rotation_svd(const Matrix3& S)
{
    const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 U = svd.matrixU();
    const Matrix3& V = svd.matrixV();
    if ((U * V.transpose()).determinant() < 0)
        U.col(2) = -U.col(2);
    return U * V.transpose();
}

Matrix3 fit_rotation(const Matrix3& S)
{
    Lanes<double> entries[9];
    for (int k = 0; k < 9; ++k)
        entries[k] = constant(S(k / 3, k % 3));
    FourFits fits;
    fits.begin(entries, constant(0.0));
    for (int step = 0; step < most_newton_steps; ++step) {
        fits.step();
        if (fits.done())
            break;
    }
    if (!fits.finish(entries)[0])
        return fit_rotation_svd(S);
    Matrix3 R;
    for (int k = 0; k < 9; ++k)
        R(k / 3, k % 3) = entries[k][0];
    return R;
}

} // namespace sinew
