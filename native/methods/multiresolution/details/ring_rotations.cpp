// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/ring_rotations.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/multiresolution/details/detail_kernels.h"
#include "native/operators/fits/fit_kernels.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>
#include <utility>

namespace sinew {

static_assert(sizeof(FaceDual) == 9 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(int));

namespace {

constexpr double least_area = 1e-7; ///< as a share of the longest edge squared

Vector3 direction(const Vector3& v, double length)
{
    return length > 0 ? Vector3(v / length) : Vector3::Zero();
}

/// The edges of a triangle from its first corner.
std::pair<Vector3, Vector3> edges_of(const PointsView& points, const Triangle& triangle)
{
    const auto [i, j, k] = triangle;
    return {(points.row(j) - points.row(i)).transpose(), (points.row(k) - points.row(i)).transpose()};
}

/// area T of face_map().
Matrix3 weighted_map(const FaceDual& dual, const PointsView& after, const Triangle& triangle)
{
    const auto [f1, f2] = edges_of(after, triangle);
    const Vector3 N1 = f1.cross(f2);
    return f1 * dual.first.transpose() + f2 * dual.second.transpose() +
           direction(N1, N1.norm()) * dual.normal.transpose();
}

} // namespace

FaceDual face_dual(const PointsView& before, const Triangle& triangle)
{
    const auto [e1, e2] = edges_of(before, triangle);
    const Vector3 N = e1.cross(e2);
    const double twice = N.norm(),
                 longest = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
    if (!(twice > 2 * least_area * longest))
        return {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    const Vector3 n = 0.5 / twice * N;
    return {e2.cross(n), n.cross(e1), 0.5 * N};
}

FaceMap face_map(const PointsView& before, const PointsView& after, const Triangle& triangle)
{
    const FaceDual dual = face_dual(before, triangle);
    const double area = dual.normal.norm();
    if (area == 0.0)
        return {Matrix3::Zero(), 0.0, 0.0, Vector3::Zero(), Vector3::Zero()};
    const auto [f1, f2] = edges_of(after, triangle);
    const Vector3 N1 = f1.cross(f2);
    const double other = N1.norm();
    return {weighted_map(dual, after, triangle), area, 0.5 * other, dual.normal / area, direction(N1, other)};
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

std::vector<FaceDual> RingRotations::duals(const PointsView& before) const
{
    std::vector<FaceDual> found(triangles_.size());
    parallel_for(static_cast<int>(found.size()), [&](int t) { found[t] = face_dual(before, triangles_[t]); });
    return found;
}

void RingRotations::map_all(const PointsView& before, const PointsView& after,
                            std::vector<Matrix3>& maps) const
{
    const DetailKernels& kernels = widest_kernels<DetailKernels>();
    maps.resize(triangles_.size());
    constexpr int block = 32;
    parallel_chunks(static_cast<int>(triangles_.size()), 64 * block, [&](int begin, int end) {
        FaceDual duals[block];
        for (int from = begin; from < end; from += block) {
            const int count = std::min(block, end - from);
            for (int k = 0; k < count; ++k)
                duals[k] = face_dual(before, triangles_[from + k]);
            kernels.maps(duals[0].first.data(), after.data(), triangles_[from].data(), count,
                         maps[from].data());
        }
    });
}

void RingRotations::map_all(const std::vector<FaceDual>& before, const PointsView& after,
                            std::vector<Matrix3>& maps) const
{
    const DetailKernels& kernels = widest_kernels<DetailKernels>();
    maps.resize(triangles_.size());
    parallel_chunks(static_cast<int>(triangles_.size()), 2048, [&](int begin, int end) {
        kernels.maps(before[begin].first.data(), after.data(), triangles_[begin].data(), end - begin,
                     maps[begin].data());
    });
}

Matrix3 RingRotations::sum_of(const std::vector<Matrix3>& maps, int vertex) const
{
    return sum_around(vertex, [&](int t) -> const Matrix3& { return maps[t]; });
}

void RingRotations::fit_four(int count, const Matrix3* matrices, Matrix3* rotations)
{
    if (count == 0)
        return;
    using Row = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    double given[36], found[36];
    for (int k = 0; k < 4; ++k)
        Eigen::Map<Row>(given + 9 * k) = k < count ? matrices[k] : Matrix3::Identity();
    const int safe = widest_kernels<FitKernels>().fit(given, found);
    for (int k = 0; k < count; ++k)
        rotations[k] =
            safe >> k & 1 ? Matrix3(Eigen::Map<const Row>(found + 9 * k)) : fit_rotation_svd(matrices[k]);
}

} // namespace sinew
