// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <vector>

namespace sinew {

/// The energy of ThinShellNonlinear, written down as its header defines it: a loop over all pairs of
/// triangles, gradients and conormals from edges, dense SVDs. For closed or open manifold meshes of sound
/// triangles.
struct ShellOracle
{
    const SurfaceMesh& mesh;
    double k_s, k_b;

    struct Cell
    {
        int a, b, triangle[2], across[2];
    };
    std::vector<Cell> cells;
    std::vector<int> count;

    ShellOracle(const SurfaceMesh& mesh, double k_s, double k_b)
        : mesh(mesh), k_s(k_s), k_b(k_b), count(mesh.triangles().size(), 0)
    {
        const auto& T = mesh.triangles();
        for (int s = 0; s < static_cast<int>(T.size()); ++s)
            for (int t = 0; t < s; ++t) {
                std::vector<int> shared, own, other;
                for (int v : T[s])
                    (std::ranges::count(T[t], v) ? shared : own).push_back(v);
                for (int v : T[t])
                    if (!std::ranges::count(T[s], v))
                        other.push_back(v);
                if (shared.size() != 2)
                    continue;
                cells.push_back({shared[0], shared[1], {s, t}, {own[0], other[0]}});
                ++count[s];
                ++count[t];
            }
    }

    static double area(const Vector3& p, const Vector3& q, const Vector3& r)
    {
        return 0.5 * (q - p).cross(r - p).norm();
    }
    /// (3, 2) the gradient of `to` over the triangle with the corners `from`, in two directions of the plane.
    static Eigen::Matrix<double, 3, 2> gradient(const Vector3 (&from)[3], const Vector3 (&to)[3])
    {
        const Vector3 u = (from[1] - from[0]).normalized();
        const Vector3 v = (from[1] - from[0]).cross(from[2] - from[0]).normalized().cross(u);
        Eigen::Matrix2d plane;
        Eigen::Matrix<double, 3, 2> edges;
        for (int k = 0; k < 2; ++k) {
            plane.col(k) << u.dot(from[k + 1] - from[0]), v.dot(from[k + 1] - from[0]);
            edges.col(k) = to[k + 1] - to[0];
        }
        return edges * plane.inverse();
    }

    double energy(const Points& q) const
    {
        double sum = 0.0;
        for (const Cell& cell : cells) {
            const double edge2 = (mesh.point(cell.a) - mesh.point(cell.b)).squaredNorm();
            double areas = 0.0, share = 0.0;
            Matrix3 S = Matrix3::Zero();
            std::vector<std::pair<double, std::pair<Vector3, Vector3>>> rows; // weight, after, before
            Vector3 K[2] = {Vector3::Zero(), Vector3::Zero()};
            for (int side = 0; side < 2; ++side) {
                const int index[3] = {cell.a, cell.b, cell.across[side]};
                Vector3 p[3], x[3];
                for (int k = 0; k < 3; ++k) {
                    p[k] = mesh.point(index[k]);
                    x[k] = q.row(index[k]).transpose();
                }
                const double A = area(p[0], p[1], p[2]);
                areas += A;
                share += 0.5 / count[cell.triangle[side]];
                const auto before = gradient(p, p), after = gradient(p, x);
                for (int k = 0; k < 2; ++k)
                    rows.push_back({k_s * A / count[cell.triangle[side]], {after.col(k), before.col(k)}});
                // The inward conormal times |e| is linear in the corners: c - (foot of c on e), scaled by
                // |e|.
                const double s = (p[2] - p[0]).dot(p[1] - p[0]) / edge2;
                const double height = 2 * A / std::sqrt(edge2);
                K[0] -= std::sqrt(edge2) / height * (x[2] - (1 - s) * x[0] - s * x[1]);
                K[1] -= std::sqrt(edge2) / height * (p[2] - (1 - s) * p[0] - s * p[1]);
            }
            const double own = share * k_s * areas * areas / (4 * edge2);
            rows.push_back({std::max(k_b - own, 0.0) / areas, {K[0], K[1]}});
            for (const auto& [w, pair] : rows)
                S += w * pair.first * pair.second.transpose();
            const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
            Matrix3 D = Matrix3::Identity();
            D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
            const Matrix3 R = svd.matrixU() * D * svd.matrixV().transpose();
            for (const auto& [w, pair] : rows)
                sum += 0.5 * w * (pair.first - R * pair.second).squaredNorm();
        }
        return sum;
    }

    /// The length of the gradient at one vertex, by central differences.
    double slope_at(Points q, int vertex, double step) const
    {
        Vector3 slope;
        for (int axis = 0; axis < 3; ++axis) {
            const double at = q(vertex, axis);
            q(vertex, axis) = at + step;
            const double above = energy(q);
            q(vertex, axis) = at - step;
            slope[axis] = (above - energy(q)) / (2 * step);
            q(vertex, axis) = at;
        }
        return slope.norm();
    }
};

} // namespace sinew
