// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/surface/linear/dense_operators.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew {

double angle_between(const Vector3& at, const Vector3& a, const Vector3& b)
{
    return std::acos((a - at).normalized().dot((b - at).normalized()));
}

MatrixX dense_laplacian(const SurfaceMesh& mesh, Discretization kind,
                        const std::function<double(const std::vector<int>&)>& scale)
{
    MatrixX L = MatrixX::Zero(mesh.vertex_count(), mesh.vertex_count());
    const auto edge = [&](int i, int j, double w) {
        L(i, i) += w;
        L(j, j) += w;
        L(i, j) -= w;
        L(j, i) -= w;
    };
    if (kind == Discretization::uniform) {
        for (const auto& [i, j] : mesh.edges())
            edge(i, j, scale({i, j}));
        return L;
    }
    for (const auto& [i, j, k] : mesh.triangles()) {
        const double s = 0.5 * scale({i, j, k});
        edge(i, j, s / std::tan(angle_between(mesh.point(k), mesh.point(i), mesh.point(j))));
        edge(j, k, s / std::tan(angle_between(mesh.point(i), mesh.point(j), mesh.point(k))));
        edge(k, i, s / std::tan(angle_between(mesh.point(j), mesh.point(k), mesh.point(i))));
    }
    return L;
}

VectorX dense_mass(const SurfaceMesh& mesh, Discretization kind)
{
    if (kind == Discretization::cotan)
        return VectorX::Ones(mesh.vertex_count());
    VectorX m = VectorX::Zero(mesh.vertex_count());
    if (kind == Discretization::uniform) {
        for (const auto& [i, j] : mesh.edges()) {
            m[i] += 1;
            m[j] += 1;
        }
        return m;
    }
    for (const Triangle& t : mesh.triangles()) {
        std::array<Vector3, 3> p{mesh.point(t[0]), mesh.point(t[1]), mesh.point(t[2])};
        const Vector3 u = p[1] - p[0], v = p[2] - p[0], n = u.cross(v);
        const double area = 0.5 * n.norm();
        const Vector3 centre =
            p[0] + (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
        std::array<double, 3> angles;
        for (int k = 0; k < 3; ++k)
            angles[k] = angle_between(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
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

} // namespace sinew
