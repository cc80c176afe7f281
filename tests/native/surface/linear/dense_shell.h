// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/surface/linear/thin_shell.h"
#include "tests/native/shapes.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>

namespace sinew {

/// The linear thin shell once more, written down from the formulas with angles, circumcentres and
/// dense matrices: shares no code with the library but the mesh and the handles' definition.
class DenseShell
{
public:
    DenseShell(const SurfaceMesh& mesh, const ThinShellOptions& options, const std::vector<Handle>& handles)
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
        const MatrixX L = laplacian([](const std::vector<int>&) { return 1.0; });
        const VectorX CM = C.cwiseQuotient(mass());
        const MatrixX stretch = laplacian([&](const auto& e) { return mean(ks, e); });
        const MatrixX vary = laplacian([&](const auto& e) { return mean(kv, e) * smooth(e); });
        A_ = stretch + L * CM.cwiseProduct(kb).asDiagonal() * L +
             L * CM.asDiagonal() * vary * CM.asDiagonal() * L;
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

    /// Deformed points; `energy` gets the elastic and the soft part.
    Points solve(const Poses& poses, double* energy = nullptr)
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
        const MatrixX rhs = (b - A_ * d)(free, Eigen::all);
        d(free, Eigen::all) = MatrixX(A_(free, free)).fullPivLu().solve(rhs);
        if (energy) {
            *energy = 0.5 * (d.transpose() * elastic_ * d).trace();
            for (const Pull& pull : pulls_)
                *energy += 0.5 * pull.stiffness *
                           (d.row(pull.vertex) - wanted(pull.vertex, pull.handle)).squaredNorm();
        }
        return mesh_.points() + d;
    }

private:
    struct Pull
    {
        int vertex, handle;
        double stiffness;
    };

    VectorX spread(const Stiffness& k) const
    {
        if (k.size() == 1)
            return VectorX::Constant(n_, k[0]);
        const VectorX values = Eigen::Map<const VectorX>(k.data(), n_);
        return values.maxCoeff() > 0 ? values.cwiseMax(1e-6 * values.maxCoeff()).eval() : values;
    }

    static double angle(const Vector3& at, const Vector3& a, const Vector3& b)
    {
        return std::acos((a - at).normalized().dot((b - at).normalized()));
    }

    MatrixX laplacian(const std::function<double(const std::vector<int>&)>& scale) const
    {
        MatrixX L = MatrixX::Zero(n_, n_);
        const auto edge = [&](int i, int j, double w) {
            L(i, i) += w;
            L(j, j) += w;
            L(i, j) -= w;
            L(j, i) -= w;
        };
        if (kind_ == Discretization::uniform) {
            for (const auto& [i, j] : mesh_.edges())
                edge(i, j, scale({i, j}));
            return L;
        }
        for (const auto& [i, j, k] : mesh_.triangles()) {
            const double s = 0.5 * scale({i, j, k});
            edge(i, j, s / std::tan(angle(mesh_.point(k), mesh_.point(i), mesh_.point(j))));
            edge(j, k, s / std::tan(angle(mesh_.point(i), mesh_.point(j), mesh_.point(k))));
            edge(k, i, s / std::tan(angle(mesh_.point(j), mesh_.point(k), mesh_.point(i))));
        }
        return L;
    }

    VectorX mass() const
    {
        if (kind_ == Discretization::cotan)
            return VectorX::Ones(n_);
        VectorX m = VectorX::Zero(n_);
        if (kind_ == Discretization::uniform) {
            for (const auto& [i, j] : mesh_.edges()) {
                m[i] += 1;
                m[j] += 1;
            }
            return m;
        }
        for (const Triangle& t : mesh_.triangles()) {
            std::array<Vector3, 3> p{mesh_.point(t[0]), mesh_.point(t[1]), mesh_.point(t[2])};
            const Vector3 u = p[1] - p[0], v = p[2] - p[0], n = u.cross(v);
            const double area = 0.5 * n.norm();
            const Vector3 centre =
                p[0] + (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
            std::array<double, 3> angles;
            for (int k = 0; k < 3; ++k)
                angles[k] = angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
            const double widest = *std::ranges::max_element(angles);
            for (int k = 0; k < 3; ++k) {
                if (widest > shapes::pi / 2) {
                    m[t[k]] += area * (angles[k] == widest ? 0.5 : 0.25);
                } else {
                    const Vector3 l = 0.5 * (p[(k + 1) % 3] - p[k]), r = 0.5 * (p[(k + 2) % 3] - p[k]);
                    m[t[k]] += 0.5 * (l.cross(centre - p[k]).norm() + r.cross(centre - p[k]).norm());
                }
            }
        }
        return m;
    }

    const SurfaceMesh& mesh_;
    Discretization kind_;
    int n_;
    std::vector<int> hard_;
    std::vector<Pull> pulls_;
    MatrixX A_, elastic_;
};

} // namespace sinew
