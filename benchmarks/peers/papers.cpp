// SPDX-License-Identifier: GPL-3.0-or-later
// Space methods as their papers print them, for one point after the other, in double precision.
#include "benchmarks/peers/papers.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace {

using Vector3 = Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

double bounded(double cosine) { return std::clamp(cosine, -1.0, 1.0); }

/// Ju, Schaefer & Warren 2005, figure 4.
void mean_value_at(const PeerCage& cage, const Vector3& x, double* w, std::vector<Vector3>& u,
                   std::vector<double>& d)
{
    std::fill(w, w + cage.vertex_count, 0.0);
    for (int j = 0; j < cage.vertex_count; ++j) {
        u[j] = cage.vertex(j) - x;
        d[j] = u[j].norm();
        u[j] /= d[j];
    }
    for (int t = 0; t < cage.triangle_count; ++t) {
        const int* const v = cage.triangles + 3 * t;
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
    double sum = 0.0;
    for (int j = 0; j < cage.vertex_count; ++j)
        sum += w[j];
    for (int j = 0; j < cage.vertex_count; ++j)
        w[j] /= sum;
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
void green_at(const PeerCage& cage, const Vector3& x, double* phi, double* psi)
{
    std::fill(phi, phi + cage.vertex_count, 0.0);
    const Vector3 origin = Vector3::Zero();
    for (int t = 0; t < cage.triangle_count; ++t) {
        const int* const f = cage.triangles + 3 * t;
        std::array<Vector3, 3> v, N;
        for (int l = 0; l < 3; ++l)
            v[l] = cage.vertex(f[l]) - x;
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
        psi[t] = -area;
        Vector3 w = area * normal;
        for (int l = 0; l < 3; ++l)
            w += II[l] * N[l];
        if (w.norm() > 1e-12)
            for (int l = 0; l < 3; ++l)
                phi[f[l]] += N[(l + 1) % 3].dot(w) / N[(l + 1) % 3].dot(v[l]);
    }
}

} // namespace

void peer_mean_value(const PeerCage& cage, const double* points, int count, double* weights)
{
    std::vector<Vector3> u(static_cast<std::size_t>(cage.vertex_count));
    std::vector<double> d(u.size());
    for (int i = 0; i < count; ++i)
        mean_value_at(cage, Vector3::Map(points + 3 * i),
                      weights + static_cast<std::size_t>(i) * cage.vertex_count, u, d);
}

void peer_green(const PeerCage& cage, const double* points, int count, double* phi, double* psi)
{
    for (int i = 0; i < count; ++i)
        green_at(cage, Vector3::Map(points + 3 * i), phi + static_cast<std::size_t>(i) * cage.vertex_count,
                 psi + static_cast<std::size_t>(i) * cage.triangle_count);
}

void peer_rigid_mls(const double* handles, const double* posed, int handle_count, const double* points,
                    int count, double* result)
{
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
