// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/pyramid/second_differences.h"

#include "native/operators/laplacian.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

/// A triangle whose height is below this share of its longest edge has no slope that means anything.
constexpr double least_height = 1e-4;

/// What the Laplacian counts beside the second differences.
constexpr double guidance = 1e-8;

struct Side
{
    int low, high;
    int apex;
    bool forward; ///< whether the triangle runs along the edge from low to high

    std::array<int, 2> edge() const { return {low, high}; }
};

} // namespace

std::vector<SecondDifference> second_differences(const Points& points, std::span<const Triangle> triangles)
{
    std::vector<Side> sides;
    sides.reserve(3 * triangles.size());
    for (const Triangle& t : triangles)
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            for (int k = 0; k < 3; ++k) {
                const int from = t[k], to = t[(k + 1) % 3];
                sides.push_back({std::min(from, to), std::max(from, to), t[(k + 2) % 3], from < to});
            }
    std::ranges::sort(sides, {}, [](const Side& s) { return std::array{s.low, s.high, s.apex}; });
    std::vector<SecondDifference> found;
    found.reserve(sides.size() / 2);
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        end = begin + 1;
        while (end < sides.size() && sides[end].edge() == sides[begin].edge())
            ++end;
        const Side &one = sides[begin], &other = sides[end - 1];
        if (end - begin != 2 || one.forward == other.forward || one.apex == other.apex)
            continue;
        const Vector3 origin = points.row(one.low).transpose(),
                      along = points.row(one.high).transpose() - origin;
        const double square = along.squaredNorm();
        double foot[2], height[2];
        bool sound = square > 0;
        for (int k = 0; k < 2 && sound; ++k) {
            const Vector3 apex = points.row(k ? other.apex : one.apex).transpose() - origin;
            foot[k] = apex.dot(along) / square;
            height[k] = (apex - foot[k] * along).norm();
            const double longest = std::max({square, apex.squaredNorm(), (apex - along).squaredNorm()});
            sound = height[k] * std::sqrt(square) > least_height * longest;
        }
        if (!sound)
            continue;
        const double first = std::sqrt(height[1] / height[0]), second = 1.0 / first;
        found.push_back({{one.low, one.high, one.apex, other.apex},
                         {-(1 - foot[0]) * first - (1 - foot[1]) * second,
                          -foot[0] * first - foot[1] * second, first, second}});
    }
    return found;
}

SparseMatrix second_difference_matrix(const SurfaceMesh& mesh, int& degenerate_faces)
{
    const TriangleMetric metric = triangle_metric(mesh);
    degenerate_faces = degenerate_face_count(mesh, metric);
    const int n = mesh.vertex_count();
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [vertices, weights] : second_differences(mesh.points(), mesh.triangles()))
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                entries.emplace_back(vertices[i], vertices[j], weights[i] * weights[j]);
    SparseMatrix H(n, n);
    H.setFromTriplets(entries.begin(), entries.end());
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan, metric);
    SparseMatrix sum = H + guidance * L;
    sum.makeCompressed();
    return sum;
}

} // namespace sinew
