// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/surface/linear/dense_implicit.h"

#include "tests/native/dense.h"

#include <Eigen/QR>

namespace sinew {

DenseImplicit::DenseImplicit(const SurfaceMesh& mesh, Discretization kind)
    : mesh_(mesh), n_(mesh.vertex_count()), L_(dense_laplacian(mesh, kind)), m_(dense_mass(mesh, kind)),
      residual_(MatrixX::Zero(3 * n_, 3 * n_)), fits_(n_)
{
    std::map<std::pair<int, int>, int> faces;
    for (const std::vector<int>& face : shapes::faces_of(mesh))
        for (std::size_t k = 0; k < face.size(); ++k)
            ++faces[std::minmax(face[k], face[(k + 1) % face.size()])];
    border_.resize(n_, false);
    for (const auto& [edge, count] : faces)
        if (count == 1)
            border_[edge.first] = border_[edge.second] = true;
    const MatrixX D = m_.cwiseInverse().asDiagonal() * L_;
    const MatrixX delta = D * mesh.points();
    for (int i = 0; i < n_; ++i) {
        for (int j = 0; j < n_; ++j)
            if (L_(i, j) != 0.0)
                rings_[i].push_back(j);
        MatrixX model(3 * rings_[i].size(), 7); // s, h, t of s x + h x x + t
        for (std::size_t k = 0; k < rings_[i].size(); ++k) {
            const Vector3 x = mesh.point(rings_[i][k]);
            model.block<3, 1>(3 * k, 0) = x;
            for (int axis = 0; axis < 3; ++axis)
                model.block<3, 1>(3 * k, 1 + axis) = Vector3::Unit(axis).cross(x);
            model.block<3, 3>(3 * k, 4) = Matrix3::Identity();
        }
        fits_[i] = model.completeOrthogonalDecomposition().pseudoInverse();
        const Vector3 own = delta.row(i).transpose();
        for (std::size_t k = 0; k < rings_[i].size(); ++k)
            for (int axis = 0; axis < 3; ++axis) {
                const int column = 3 * rings_[i][k] + axis;
                const VectorX fit = fits_[i].col(3 * k + axis);
                const Vector3 turn = border_[i] ? Vector3::Zero() : Vector3(fit.segment<3>(1));
                residual_.block<3, 1>(3 * i, column) -= fit[0] * own + turn.cross(own);
            }
        for (int j = 0; j < n_; ++j)
            residual_.block<3, 3>(3 * i, 3 * j) += D(i, j) * Matrix3::Identity();
    }
}

Points DenseImplicit::solve(const std::vector<Handle>& handles, const Poses& poses, const Matrix3& R) const
{
    const VectorX weights = m_.replicate(1, 3).transpose().reshaped();
    const MatrixX bend = (m_.cwiseInverse().asDiagonal() * L_).eval();
    MatrixX H = residual_.transpose() * weights.asDiagonal() * residual_;
    const MatrixX plain = 1e-7 * bend.transpose() * m_.asDiagonal() * bend;
    for (int i = 0; i < n_; ++i)
        for (int j = 0; j < n_; ++j)
            H.block<3, 3>(3 * i, 3 * j) += plain(i, j) * Matrix3::Identity();
    const VectorX diagonal = H.diagonal();
    VectorX d = VectorX::Zero(3 * n_), b = d;
    std::vector<bool> held(n_, false);
    for (std::size_t h = 0; h < handles.size(); ++h)
        for (std::size_t k = 0; k < handles[h].vertices.size(); ++k) {
            const int v = handles[h].vertices[k];
            const Vector3 wanted = R.transpose() * apply(poses[h], mesh_.point(v)) - mesh_.point(v);
            const double w = handles[h].weights.empty() ? 1.0 : handles[h].weights[k];
            if (w == 1.0) {
                d.segment<3>(3 * v) = wanted;
                held[v] = true;
            } else {
                const double s = w / (1 - w) * diagonal.segment<3>(3 * v).mean();
                b.segment<3>(3 * v) += s * wanted;
                H.diagonal().segment<3>(3 * v).array() += s;
            }
        }
    std::vector<int> free;
    for (int row = 0; row < 3 * n_; ++row)
        if (!held[row / 3])
            free.push_back(row);
    return dense::solution(H, b, d, free).reshaped<Eigen::RowMajor>(n_, 3);
}

std::vector<Eigen::Vector4d> DenseImplicit::fitted(const Points& displacements) const
{
    std::vector<Eigen::Vector4d> found;
    for (int i = 0; i < n_; ++i) {
        VectorX x(3 * rings_.at(i).size());
        for (std::size_t k = 0; k < rings_.at(i).size(); ++k)
            x.segment<3>(3 * k) =
                mesh_.point(rings_.at(i)[k]) + displacements.row(rings_.at(i)[k]).transpose();
        found.emplace_back((fits_[i] * x).head<4>());
    }
    return found;
}

} // namespace sinew
