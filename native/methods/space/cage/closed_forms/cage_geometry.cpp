// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/cage_geometry.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

namespace sinew {

namespace {

constexpr double least_height = 1e-8;

/// The squared distance of a point from a segment.
double from_segment(const Vector3& x, const Vector3& a, const Vector3& b)
{
    const Vector3 along = b - a;
    const double share = std::clamp((x - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (x - a - share * along).squaredNorm();
}

} // namespace

CageGeometry::CageGeometry(const Cage& cage, const std::vector<char>& without)
    : centre_(0.5 * (cage.rest().points().colwise().maxCoeff() + cage.rest().points().colwise().minCoeff())
                        .transpose()),
      size_(cage.size())
{
    for (int v = 0; v < cage.vertex_count(); ++v) {
        const Vector3 p = (cage.rest().point(v) - centre_) / size_;
        vertices_.insert(vertices_.end(), {p.x(), p.y(), p.z()});
    }
    std::map<std::pair<int, int>, int> index;
    const auto edge_between = [&](int a, int b) {
        const auto [found, fresh] = index.try_emplace(std::minmax(a, b), static_cast<int>(edges_.size()));
        if (fresh) {
            CageEdge edge{std::min(a, b), std::max(a, b), 0.0, {}};
            const Vector3 along = vertex(edge.b) - vertex(edge.a);
            edge.length = along.norm();
            Vector3::Map(edge.direction) = along / edge.length;
            edges_.push_back(edge);
        }
        return found->second;
    };
    const std::vector<Triangle>& all = cage.triangles();
    for (int t = 0; t < static_cast<int>(all.size()); ++t) {
        const int face = cage.rest().triangle_faces()[static_cast<std::size_t>(t)];
        if (!without.empty() && without[static_cast<std::size_t>(face)])
            continue;
        const std::array<Vector3, 3> v{vertex(all[t][0]), vertex(all[t][1]), vertex(all[t][2])};
        const Vector3 area = (v[1] - v[0]).cross(v[2] - v[0]);
        const double longest = std::max({(v[1] - v[0]).norm(), (v[2] - v[1]).norm(), (v[0] - v[2]).norm()});
        if (!(area.norm() > least_height * longest))
            continue;
        CageTriangle triangle{};
        triangle.double_area = area.norm();
        const Vector3 normal = area / triangle.double_area;
        Vector3::Map(triangle.normal) = normal;
        std::array<Vector3, 3> outward;
        for (int k = 0; k < 3; ++k) {
            triangle.corners[k] = all[t][k];
            triangle.edges[k] = edge_between(all[t][(k + 1) % 3], all[t][(k + 2) % 3]);
            const Vector3 side = v[(k + 2) % 3] - v[(k + 1) % 3];
            triangle.inverse_height[k] = side.norm() / triangle.double_area;
            outward[k] = side.normalized().cross(normal);
            Vector3::Map(triangle.outward[k]) = outward[k];
        }
        for (int k = 0; k < 3; ++k)
            triangle.cosines[k] = outward[(k + 1) % 3].dot(outward[(k + 2) % 3]);
        // The sum for T in MeanValue has terms of at most the size of the side over its distance. So above this
        // height h, a weight loses 1e-16 / h, times the longest side over the least height of the triangle:
        // less than 1e-12 of the sum of all weights, which is at least 4 pi.
        triangle.near =
            3e-4 * longest * *std::max_element(triangle.inverse_height, triangle.inverse_height + 3);
        triangles_.push_back(triangle);
        kept_.push_back(t);
    }
    if (triangles_.empty() && std::find(without.begin(), without.end(), 1) == without.end())
        throw InvalidMesh("no face of the cage has an area");
}

CageTables CageGeometry::tables() const
{
    return {vertices_.data(),
            edges_.data(),
            triangles_.data(),
            static_cast<int>(vertices_.size() / 3),
            static_cast<int>(edges_.size()),
            static_cast<int>(triangles_.size())};
}

Vector3 CageGeometry::within_reach(const Vector3& x) const
{
    constexpr double reach = 1000.0;
    const double most = x.cwiseAbs().maxCoeff();
    if (!(most > reach / 2))
        return x;
    const Vector3 scaled = x / most;
    return most * scaled.norm() > reach ? Vector3(reach * scaled.normalized()) : x;
}

Vector3 CageGeometry::barycentric(int t, const Vector3& x) const
{
    const CageTriangle& triangle = triangles_[static_cast<std::size_t>(t)];
    const auto share = [&](int k) {
        return triangle.inverse_height[k] *
               Vector3::Map(triangle.outward[k]).dot(vertex(triangle.corners[(k + 1) % 3]) - x);
    };
    const double first = share(0), second = share(1);
    return {first, second, 1.0 - first - second};
}

double CageGeometry::depth(int t, const Vector3& x) const
{
    const CageTriangle& triangle = triangles_[static_cast<std::size_t>(t)];
    return Vector3::Map(triangle.normal).dot(vertex(triangle.corners[0]) - x);
}

int CageGeometry::nearest(const Vector3& x) const
{
    int found = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
        if (const double square = square_distance(t, x); square < least) {
            least = square;
            found = t;
        }
    return found;
}

double CageGeometry::square_distance(int t, const Vector3& x) const
{
    const CageTriangle& triangle = triangles_[static_cast<std::size_t>(t)];
    if (barycentric(t, x).minCoeff() >= 0.0) {
        const double h = depth(t, x);
        return h * h;
    }
    double least = 1e300;
    for (int k = 0; k < 3; ++k)
        least = std::min(least,
                         from_segment(x, vertex(triangle.corners[k]), vertex(triangle.corners[(k + 1) % 3])));
    return least;
}

} // namespace sinew
