// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/ring_rotations.h"

#include "native/core/parallel.h"
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

void RingRotations::fit(const PointsView& before, const PointsView& after, std::vector<Matrix3>& maps,
                        const Wanted& wanted, const Use& use) const
{
    maps.resize(triangles_.size());
    parallel_for(static_cast<int>(triangles_.size()),
                 [&](int t) { maps[t] = face_map(before, after, triangles_[t]).weighted; });
    parallel_for(static_cast<int>(before.rows()), [&](int v) {
        if (!wanted(v))
            return;
        Matrix3 sum = Matrix3::Zero();
        for (int t : around(v))
            sum += maps[t];
        if (sum.isZero(0.0))
            for (int t : around(v))
                for (int corner : triangles_[t])
                    for (int other : around(corner))
                        sum += maps[other];
        use(v, fit_rotation(sum));
    });
}

} // namespace sinew
