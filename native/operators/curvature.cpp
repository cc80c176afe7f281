// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/curvature.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/half_edges.h"
#include "native/operators/laplacian.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <string>

namespace sinew {

namespace {

/// What has more neighbours, a hub or a face of many corners, is left out of the rings of others: all around
/// would count each time.
constexpr int most_around = 200;
constexpr int enough_for_cubic = 15, enough_for_quadric = 7; ///< neighbours, for 9 and for 5 coefficients

/// The faces at each vertex.
class FacesAround
{
public:
    explicit FacesAround(const SurfaceMesh& mesh) : mesh_(mesh), begin_(mesh.vertex_count() + 1, 0)
    {
        for (int f = 0; f < mesh.face_count(); ++f)
            for (int v : mesh.face(f))
                ++begin_[v + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        faces_.resize(begin_.back());
        std::vector<int> next(begin_.begin(), begin_.end() - 1);
        for (int f = 0; f < mesh.face_count(); ++f)
            for (int v : mesh.face(f))
                faces_[next[v]++] = f;
    }

    /// The vertices of at least so many rings of faces around a vertex, without it, ascending.
    std::vector<int> neighbours(int vertex, int rings) const
    {
        std::vector<int> near{vertex}, front = near, faces, ring, joined;
        for (int k = 0; !front.empty() && (k < rings || std::ssize(near) <= enough_for_cubic); ++k) {
            faces.clear();
            for (int v : front)
                if (v == vertex || begin_[v + 1] - begin_[v] <= most_around)
                    faces.insert(faces.end(), faces_.begin() + begin_[v], faces_.begin() + begin_[v + 1]);
            std::ranges::sort(faces);
            faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
            ring.clear();
            for (int f : faces)
                if (mesh_.face(f).size() <= most_around)
                    std::ranges::copy(mesh_.face(f), std::back_inserter(ring));
            std::ranges::sort(ring);
            ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
            front.clear();
            std::ranges::set_difference(ring, near, std::back_inserter(front));
            joined.clear();
            std::ranges::merge(near, front, std::back_inserter(joined));
            near.swap(joined);
        }
        near.erase(std::ranges::lower_bound(near, vertex));
        return near;
    }

private:
    const SurfaceMesh& mesh_;
    std::vector<int> begin_, faces_;
};

struct Corners
{
    Points normals; ///< unit, or 0
    VectorX angles; ///< the sum around each vertex
};

/// Normals that are exact on spheres, whatever the faces (N. Max. "Weights for Computing Vertex Normals from
/// Facet Normals." Journal of Graphics Tools 4(2), 1999), and angles.
Corners corners_of(const SurfaceMesh& mesh)
{
    Corners sums{Points::Zero(mesh.vertex_count(), 3), VectorX::Zero(mesh.vertex_count())};
    for (const Triangle& t : mesh.triangles())
        for (int k = 0; k < 3; ++k) {
            const Vector3 a = mesh.point(t[(k + 1) % 3]) - mesh.point(t[k]);
            const Vector3 b = mesh.point(t[(k + 2) % 3]) - mesh.point(t[k]);
            const Vector3 normal = a.cross(b);
            sums.angles[t[k]] += std::atan2(normal.norm(), a.dot(b));
            const double weight = a.squaredNorm() * b.squaredNorm();
            if (weight > 0.0)
                sums.normals.row(t[k]) += (normal / weight).transpose();
        }
    sums.normals.rowwise().normalize();
    return sums;
}

/// Two unit vectors that make a right-handed frame with a unit normal.
std::array<Vector3, 2> plane_of(const Vector3& normal)
{
    Eigen::Index axis;
    normal.cwiseAbs().minCoeff(&axis);
    const Vector3 u = Vector3::Unit(axis).cross(normal).normalized();
    return {u, normal.cross(u)};
}

/// The derivatives of a height field at its origin.
struct Jet
{
    double u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;
};

/// \param frame  axes u and v of the plane, and its normal.
Jet fitted_jet(const SurfaceMesh& mesh, int vertex, const std::vector<int>& near,
               const std::array<Vector3, 3>& frame)
{
    const int count = static_cast<int>(near.size());
    if (count == 0)
        return {};
    double unit = 0.0; // the mean distance, so that all columns are of one size
    for (int v : near)
        unit += (mesh.point(v) - mesh.point(vertex)).norm() / count;
    if (!(unit > 0.0))
        return {};
    MatrixX A(count, count >= enough_for_cubic ? 9 : 5);
    VectorX b(count);
    for (int k = 0; k < count; ++k) {
        const Vector3 p = (mesh.point(near[k]) - mesh.point(vertex)) / unit;
        const double x = p.dot(frame[0]), y = p.dot(frame[1]);
        const double weight =
            1.0 / std::max(std::hypot(x, y), 0.1); // what is near counts as much as what is far
        A.row(k).head<5>() << x, y, 0.5 * x * x, x * y, 0.5 * y * y;
        if (A.cols() == 9)
            A.row(k).tail<4>() << x * x * x, x * x * y, x * y * y, y * y * y;
        A.row(k) *= weight;
        b[k] = weight * p.dot(frame[2]);
    }
    // Where the neighbours leave a coefficient open, it is as small as can be.
    LeastNorm fit;
    fit.factorize(A, 1e-5);
    const VectorX c = fit.solve(b);
    return {c[0], c[1], c[2] / unit, c[3] / unit, c[4] / unit};
}

/// Turns a direction round unless the first of its coordinates that is clearly the largest is positive.
Vector3 signed_by_axes(const Vector3& d)
{
    const double most = 0.9 * d.cwiseAbs().maxCoeff();
    for (double x : d)
        if (std::abs(x) > most)
            return x < 0 ? Vector3(-d) : d;
    return d;
}

} // namespace

VectorX Curvature::along(const PointsView& directions) const
{
    if (directions.rows() != mean.size())
        throw InvalidOption("directions: " + std::to_string(directions.rows()) + " are not one for each of " +
                            std::to_string(mean.size()) + " vertices");
    if (!directions.allFinite())
        throw InvalidOption("directions: NaN or infinite coordinates");
    VectorX result(mean.size());
    for (Eigen::Index i = 0; i < result.size(); ++i) {
        const double E = first_form[0][i], F = first_form[1][i], G = first_form[2][i];
        const double largest = directions.row(i).cwiseAbs().maxCoeff();
        const Vector3 d = largest > 0.0 ? Vector3(directions.row(i).transpose() / largest) : Vector3::Zero();
        const double du = tangents[0].row(i).dot(d), dv = tangents[1].row(i).dot(d);
        const double a = G * du - F * dv, b = E * dv - F * du; // t, but for its length
        const double square = a * a * E + 2 * a * b * F + b * b * G;
        const double bend =
            a * a * second_form[0][i] + 2 * a * b * second_form[1][i] + b * b * second_form[2][i];
        result[i] = square > 0.0 ? bend / square : 0.0;
    }
    return result;
}

Curvature curvature(const SurfaceMesh& mesh, int rings)
{
    if (rings < 1)
        throw InvalidOption("rings: " + std::to_string(rings) + " is below 1");
    const int n = mesh.vertex_count();
    const auto numbers = [n] { return VectorX(VectorX::Zero(n)); };
    const auto vectors = [n] { return Points(Points::Zero(n, 3)); };
    Curvature found{numbers(),
                    numbers(),
                    vectors(),
                    {numbers(), numbers()},
                    {vectors(), vectors()},
                    {vectors(), vectors()},
                    {numbers(), numbers(), numbers()},
                    {numbers(), numbers(), numbers()}};

    const FacesAround around(mesh);
    const auto [normals, angles] = corners_of(mesh);
    const TriangleMetric metric = triangle_metric(mesh);
    const MatrixX Lx = laplacian_matrix(mesh, Discretization::cotan_voronoi, metric) * mesh.points();
    const VectorX mass = divisible_mass(mesh, Discretization::cotan_voronoi, metric);
    std::vector<char> inside(n, 1); // whether two faces meet at each edge of the vertex
    for_each_edge(sorted_half_edges(mesh), [&](std::span<const HalfEdge> along) {
        if (along.size() != 2)
            inside[along[0].low] = inside[along[0].high] = 0;
    });

    parallel_for(
        n,
        [&](int i) {
            const Vector3 plane_normal = normals.row(i).transpose();
            if (!(plane_normal.squaredNorm() > 0.5))
                return;
            const auto [u, v] = plane_of(plane_normal);
            const Jet jet = fitted_jet(mesh, i, around.neighbours(i, rings), {u, v, plane_normal});

            const Vector3 x_u = u + jet.u * plane_normal, x_v = v + jet.v * plane_normal;
            const double E = x_u.squaredNorm(), F = x_u.dot(x_v), G = x_v.squaredNorm();
            const double stretch = std::sqrt(E * G - F * F); // >= 1: |x_u x x_v|
            const double e = -jet.uu / stretch, f = -jet.uv / stretch, g = -jet.vv / stretch;
            const Vector3 normal = x_u.cross(x_v) / stretch;
            found.normals.row(i) = normal.transpose();
            found.tangents[0].row(i) = x_u.transpose();
            found.tangents[1].row(i) = x_v.transpose();
            found.first_form[0][i] = E;
            found.first_form[1][i] = F;
            found.first_form[2][i] = G;
            found.second_form[0][i] = e;
            found.second_form[1][i] = f;
            found.second_form[2][i] = g;

            // The second form in orthonormal axes a and b, from x_u and what of x_v is at right angles to it.
            const double p = 1.0 / std::sqrt(E), q = std::sqrt(E) / stretch, r = -F / E;
            const Vector3 a = p * x_u, b = q * (x_v + r * x_u);
            const double aa = p * p * e, ab = p * q * (f + r * e), bb = q * q * (g + r * (2 * f + r * e));
            const double half_sum = 0.5 * (aa + bb), radius = std::hypot(0.5 * (aa - bb), ab);
            const double angle = 0.5 * std::atan2(2 * ab, aa - bb); // of the largest
            const Vector3 first = signed_by_axes((std::sin(angle) * a - std::cos(angle) * b).normalized());
            found.principal[0][i] = half_sum - radius;
            found.principal[1][i] = half_sum + radius;
            found.directions[0].row(i) = first.transpose();
            found.directions[1].row(i) = normal.cross(first).transpose();

            const bool usual = inside[i] && mass[i] > 0.0;
            found.mean[i] = usual ? 0.5 * Lx.row(i).dot(normal) / mass[i] : half_sum;
            found.gaussian[i] =
                usual ? (2 * std::numbers::pi - angles[i]) / mass[i] : half_sum * half_sum - radius * radius;
        },
        256);
    return found;
}

} // namespace sinew
