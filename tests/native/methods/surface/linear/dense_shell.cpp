// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/surface/linear/dense_shell.h"

#include "tests/native/dense.h"

namespace sinew {

DenseShell::DenseShell(const SurfaceMesh& mesh, const ThinShellOptions& options,
                       const std::vector<Handle>& handles)
    : mesh_(mesh), kind_(options.laplacian), n_(mesh.vertex_count()), hard_(n_, -1)
{
    VectorX C = VectorX::Ones(n_);
    for (int h = 0; h < static_cast<int>(handles.size()); ++h)
        for (std::size_t k = 0; k < handles[h].vertices.size(); ++k)
            if (handles[h].weights.empty() || handles[h].weights[k] == 1.0) {
                hard_[handles[h].vertices[k]] = h;
                C[handles[h].vertices[k]] = std::min(handles[h].continuity, 1.0);
            }
    const VectorX ks = spread(options.stretching), kb = spread(options.bending),
                  kv = spread(options.variation);
    const auto mean = [](const VectorX& k, const std::vector<int>& element) {
        double sum = 0;
        for (int v : element)
            sum += k[v];
        return sum / static_cast<double>(element.size());
    };
    const auto smooth = [&](const std::vector<int>& element) {
        double least = 1.0;
        for (int v : element) {
            if (hard_[v] < 0)
                return 1.0;
            least = std::min(least, std::max(handles[hard_[v]].continuity - 1.0, 0.0));
        }
        return least;
    };
    const MatrixX L = dense_laplacian(mesh, kind_);
    const VectorX CM = C.cwiseQuotient(dense_mass(mesh, kind_));
    const MatrixX stretch = dense_laplacian(mesh, kind_, [&](const auto& e) { return mean(ks, e); });
    const MatrixX vary = dense_laplacian(mesh, kind_, [&](const auto& e) { return mean(kv, e) * smooth(e); });
    A_ =
        stretch + L * CM.cwiseProduct(kb).asDiagonal() * L + L * CM.asDiagonal() * vary * CM.asDiagonal() * L;
    elastic_ = A_;
    for (int h = 0; h < static_cast<int>(handles.size()); ++h)
        for (std::size_t k = 0; k < handles[h].weights.size(); ++k) {
            const int v = handles[h].vertices[k];
            const double w = handles[h].weights[k];
            if (hard_[v] < 0 && w > 0)
                pulls_.push_back({v, h, w / (1 - w) * elastic_(v, v)});
        }
    for (const Pull& pull : pulls_)
        A_(pull.vertex, pull.vertex) += pull.stiffness;
}

Points DenseShell::solve(const Poses& poses, double* energy)
{
    MatrixX d = MatrixX::Zero(n_, 3), b = MatrixX::Zero(n_, 3);
    const auto wanted = [&](int v, int h) -> Eigen::RowVector3d {
        return (apply(poses[h], mesh_.point(v)) - mesh_.point(v)).transpose();
    };
    for (const Pull& pull : pulls_)
        b.row(pull.vertex) += pull.stiffness * wanted(pull.vertex, pull.handle);
    std::vector<int> free;
    for (int v = 0; v < n_; ++v) {
        if (hard_[v] >= 0)
            d.row(v) = wanted(v, hard_[v]);
        else
            free.push_back(v);
    }
    d = dense::solution(A_, b, d, free);
    if (energy) {
        *energy = 0.5 * (d.transpose() * elastic_ * d).trace();
        for (const Pull& pull : pulls_)
            *energy +=
                0.5 * pull.stiffness * (d.row(pull.vertex) - wanted(pull.vertex, pull.handle)).squaredNorm();
    }
    return mesh_.points() + d;
}

VectorX DenseShell::spread(const Stiffness& k) const
{
    if (k.size() == 1)
        return VectorX::Constant(n_, k[0]);
    const VectorX values = Eigen::Map<const VectorX>(k.data(), n_);
    return values.maxCoeff() > 0 ? values.cwiseMax(1e-6 * values.maxCoeff()).eval() : values;
}

} // namespace sinew
