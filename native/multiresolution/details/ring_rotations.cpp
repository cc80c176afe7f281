// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/ring_rotations.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fit_kernels.h"
#include "native/operators/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

constexpr double least_area = 1e-7; ///< as a share of the longest edge squared

Vector3 direction(const Vector3& v, double length)
{
    return length > 0 ? Vector3(v / length) : Vector3::Zero();
}

/// Vertices whose rotations are fitted together.
struct FourRings
{
    const FitKernels& kernels = widest_kernels<FitKernels>();
    int count = 0;
    int vertices[4];
    Matrix3 sums[4];

    void add(int vertex, const Matrix3& sum)
    {
        vertices[count] = vertex;
        sums[count++] = sum;
    }

    void fit(const RingRotations::Use& use)
    {
        using Row = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        std::fill(sums + count, sums + 4, Matrix3::Identity());
        double given[36], found[36];
        for (int k = 0; k < 4; ++k)
            Eigen::Map<Row>(given + 9 * k) = sums[k];
        const int safe = kernels.fit(given, found);
        for (int k = 0; k < count; ++k)
            use(vertices[k],
                safe >> k & 1 ? Matrix3(Eigen::Map<const Row>(found + 9 * k)) : fit_rotation_svd(sums[k]));
        count = 0;
    }
};

} // namespace

FaceMap face_map(const PointsView& before, const PointsView& after, const Triangle& triangle)
{
    const auto [i, j, k] = triangle;
    const Vector3 e1 = (before.row(j) - before.row(i)).transpose(),
                  e2 = (before.row(k) - before.row(i)).transpose(),
                  f1 = (after.row(j) - after.row(i)).transpose(),
                  f2 = (after.row(k) - after.row(i)).transpose();
    const Vector3 N = e1.cross(e2), N1 = f1.cross(f2);
    const double twice = N.norm(), other = N1.norm(),
                 longest = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
    if (!(twice > 2 * least_area * longest))
        return {Matrix3::Zero(), 0.0, 0.0, Vector3::Zero(), Vector3::Zero()};
    const Vector3 n = direction(N, twice), n1 = direction(N1, other);
    FaceMap map;
    map.weighted = 0.5 * (f1 * e2.cross(n).transpose() + f2 * n.cross(e1).transpose() + n1 * N.transpose());
    map.area = 0.5 * twice;
    map.other_area = 0.5 * other;
    map.normal = n;
    map.other_normal = n1;
    return map;
}

RingRotations::RingRotations(const SurfaceMesh& mesh)
    : triangles_(mesh.triangles()), offsets_(mesh.vertex_count() + 1, 0), around_(3 * triangles_.size())
{
    for (const Triangle& t : triangles_)
        for (int v : t)
            ++offsets_[v + 1];
    std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
        for (int v : triangles_[t])
            around_[next[v]++] = t;
}

template <class Map>
Matrix3 RingRotations::sum_around(int vertex, const Map& map) const
{
    Matrix3 sum = Matrix3::Zero();
    for (int t : around(vertex))
        sum += map(t);
    if (sum.isZero(0.0))
        for (int t : around(vertex))
            for (int corner : triangles_[t])
                for (int other : around(corner))
                    sum += map(other);
    return sum;
}

Matrix3 RingRotations::at(const PointsView& before, const PointsView& after, int vertex) const
{
    return fit_rotation(
        sum_around(vertex, [&](int t) { return face_map(before, after, triangles_[t]).weighted; }));
}

void RingRotations::fit(const PointsView& before, const PointsView& after, std::vector<Matrix3>& maps,
                        const Wanted& wanted, const Use& use) const
{
    maps.resize(triangles_.size());
    parallel_for(static_cast<int>(triangles_.size()),
                 [&](int t) { maps[t] = face_map(before, after, triangles_[t]).weighted; });
    parallel_chunks(static_cast<int>(before.rows()), 2048, [&](int begin, int end) {
        FourRings rings;
        for (int v = begin; v < end; ++v)
            if (wanted(v)) {
                rings.add(v, sum_around(v, [&](int t) -> const Matrix3& { return maps[t]; }));
                if (rings.count == 4)
                    rings.fit(use);
            }
        rings.fit(use);
    });
}

} // namespace sinew
