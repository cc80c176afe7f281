// SPDX-License-Identifier: GPL-3.0-or-later
// Space methods as their papers print them, for one point after the other, in double precision.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <pybind11/eigen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace {

using Vector3 = Eigen::Vector3d;
using Points = Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>;
using Triangles = Eigen::Ref<const Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>>;
using Rows = Eigen::Ref<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
constexpr double pi = std::numbers::pi;

double bounded(double cosine) { return std::clamp(cosine, -1.0, 1.0); }

Vector3 at(const Points& points, Eigen::Index k) { return Vector3::Map(points.data() + 3 * k); }

/// Ju, Schaefer & Warren 2005, figure 4.
void mean_value(const Points& vertices, const Triangles& triangles, const Points& points, Rows weights)
{
    std::vector<Vector3> u(static_cast<std::size_t>(vertices.rows()));
    std::vector<double> d(u.size());
    weights.setZero();
    for (Eigen::Index point = 0; point < points.rows(); ++point) {
        const Vector3 x = at(points, point);
        double* const w = &weights(point, 0);
        for (Eigen::Index j = 0; j < vertices.rows(); ++j) {
            u[j] = at(vertices, j) - x;
            d[j] = u[j].norm();
            u[j] /= d[j];
        }
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            const int* const v = triangles.data() + 3 * t;
            std::array<double, 3> theta, c, s;
            for (int i = 0; i < 3; ++i)
                theta[i] = 2.0 * std::asin((u[v[(i + 1) % 3]] - u[v[(i + 2) % 3]]).norm() / 2.0);
            const double h = (theta[0] + theta[1] + theta[2]) / 2.0;
            const double sign = u[v[0]].dot(u[v[1]].cross(u[v[2]])) < 0.0 ? -1.0 : 1.0;
            bool in_plane = false;
            for (int i = 0; i < 3; ++i) {
                c[i] = 2.0 * std::sin(h) * std::sin(h - theta[i]) /
                           (std::sin(theta[(i + 1) % 3]) * std::sin(theta[(i + 2) % 3])) -
                       1.0;
                s[i] = sign * std::sqrt(std::max(0.0, 1.0 - c[i] * c[i]));
                in_plane = in_plane || std::abs(s[i]) <= 1e-9;
            }
            if (in_plane)
                continue;
            for (int i = 0; i < 3; ++i) {
                const int next = (i + 1) % 3, last = (i + 2) % 3;
                w[v[i]] += (theta[i] - c[next] * theta[last] - c[last] * theta[next]) /
                           (d[v[i]] * std::sin(theta[next]) * s[last]);
            }
        }
        weights.row(point) /= weights.row(point).sum();
    }
}

/// Lipman, Levin & Cohen-Or 2008, appendix: GCTriInt.
double triangle_integral(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& x)
{
    const double alpha = std::acos(bounded((b - a).dot(p - a) / ((b - a).norm() * (p - a).norm())));
    const double beta = std::acos(bounded((a - p).dot(b - p) / ((a - p).norm() * (b - p).norm())));
    const double lambda = (p - a).squaredNorm() * std::sin(alpha) * std::sin(alpha);
    const double c = (p - x).squaredNorm();
    const auto primitive = [&](double theta) {
        const double S = std::sin(theta), C = std::cos(theta);
        const double sign = S < 0.0 ? -1.0 : S > 0.0 ? 1.0 : 0.0;
        if (sign == 0.0)
            return 0.0;
        const double inner =
            2.0 * std::sqrt(lambda) * S * S / ((1.0 - C) * (1.0 - C)) *
            (1.0 - 2.0 * c * C / (c * (1.0 + C) + lambda + std::sqrt(lambda * lambda + lambda * c * S * S)));
        return -sign / 2.0 *
               (2.0 * std::sqrt(c) * std::atan(std::sqrt(c) * C / std::sqrt(lambda + S * S * c)) +
                std::sqrt(lambda) * std::log(inner));
    };
    return -std::abs(primitive(pi - alpha) - primitive(pi - alpha - beta) - std::sqrt(c) * beta) / (4.0 * pi);
}

/// Lipman, Levin & Cohen-Or 2008, appendix.
void green(const Points& vertices, const Triangles& triangles, const Points& points, Rows phi, Rows psi)
{
    phi.setZero();
    const Vector3 origin = Vector3::Zero();
    for (Eigen::Index point = 0; point < points.rows(); ++point)
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            const int* const f = triangles.data() + 3 * t;
            std::array<Vector3, 3> v, N;
            for (int l = 0; l < 3; ++l)
                v[l] = at(vertices, f[l]) - at(points, point);
            const Vector3 normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
            const Vector3 p = v[0].dot(normal) * normal;
            std::array<double, 3> s, I, II;
            for (int l = 0; l < 3; ++l) {
                const Vector3 &a = v[l], &b = v[(l + 1) % 3];
                s[l] = (a - p).cross(b - p).dot(normal) < 0.0 ? -1.0 : 1.0;
                I[l] = triangle_integral(p, a, b, origin);
                II[l] = triangle_integral(origin, b, a, origin);
                N[l] = b.cross(a).normalized();
            }
            const double area = -std::abs(s[0] * I[0] + s[1] * I[1] + s[2] * I[2]);
            psi(point, t) = -area;
            const Vector3 w = area * normal + II[0] * N[0] + II[1] * N[1] + II[2] * N[2];
            if (w.norm() > 1e-12)
                for (int l = 0; l < 3; ++l)
                    phi(point, f[l]) += N[(l + 1) % 3].dot(w) / N[(l + 1) % 3].dot(v[l]);
        }
}

/// Schaefer, McPhail & Warren 2006, with rotations by a singular value decomposition.
void rigid_mls(const Points& handles, const Points& posed, const Points& points, Rows result)
{
    Eigen::VectorXd w(handles.rows());
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const Vector3 x = at(points, v);
        for (Eigen::Index i = 0; i < handles.rows(); ++i)
            w[i] = 1.0 / (at(handles, i) - x).squaredNorm();
        const Vector3 p_star = handles.transpose() * w / w.sum(), q_star = posed.transpose() * w / w.sum();
        Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
        for (Eigen::Index i = 0; i < handles.rows(); ++i)
            M += w[i] * (at(posed, i) - q_star) * (at(handles, i) - p_star).transpose();
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Matrix3d U = svd.matrixU();
        if ((U * svd.matrixV().transpose()).determinant() < 0)
            U.col(2) = -U.col(2);
        result.row(v) = (U * svd.matrixV().transpose() * (x - p_star) + q_star).transpose();
    }
}

} // namespace

void bind_papers(pybind11::module_& m)
{
    using namespace pybind11::literals;
    m.def("mean_value", &mean_value, "vertices"_a, "triangles"_a, "points"_a, "weights"_a);
    m.def("green", &green, "vertices"_a, "triangles"_a, "points"_a, "phi"_a, "psi"_a);
    m.def("rigid_mls", &rigid_mls, "handles"_a, "posed"_a, "points"_a, "result"_a);
}
