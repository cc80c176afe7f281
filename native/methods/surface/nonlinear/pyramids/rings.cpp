// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/rings.h"

#include "native/core/dense.h"
#include "native/core/parallel.h"
#include "native/operators/fits/rotation_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sinew {

namespace {

Vector3 edge(const PointsView& points, int from, int to)
{
    return (points.row(to) - points.row(from)).transpose();
}

} // namespace

Rings::Rings(const SurfaceMesh& mesh)
{
    const int n = mesh.vertex_count();
    std::vector<std::vector<int>> rings(n);
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles())
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            triangles.push_back(t);
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            rings[t[k]].push_back(t[(k + 1) % 3]);
            rings[t[k]].push_back(t[(k + 2) % 3]);
        }
    for (std::vector<int>& ring : rings) {
        std::ranges::sort(ring);
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        neighbours_.insert(neighbours_.end(), ring.begin(), ring.end());
        offsets_.push_back(static_cast<int>(neighbours_.size()));
    }

    const auto directed = [&](int from, int to) {
        const auto first = neighbours_.begin() + offsets_[from],
                   last = neighbours_.begin() + offsets_[from + 1];
        return static_cast<int>(std::lower_bound(first, last, to) - neighbours_.begin());
    };
    first_corner_.assign(n + 1, 0);
    for (const Triangle& t : triangles)
        for (const int v : t)
            ++first_corner_[v + 1];
    std::partial_sum(first_corner_.begin(), first_corner_.end(), first_corner_.begin());
    corners_.resize(first_corner_.back());
    std::vector<int> next(first_corner_.begin(), first_corner_.end() - 1);
    // A ring is closed if one triangle arrives at each of its vertices, and one leaves it.
    std::vector<int> leaving(neighbours_.size(), 0), arriving(neighbours_.size(), 0);
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const int a = directed(t[k], t[(k + 1) % 3]), b = directed(t[k], t[(k + 2) % 3]);
            corners_[next[t[k]]++] = {a, b};
            ++leaving[a];
            ++arriving[b];
        }
    closed_.assign(n, true);
    for (int i = 0; i < n; ++i)
        for (int a = offsets_[i]; a < offsets_[i + 1]; ++a)
            closed_[i] = closed_[i] && leaving[a] == 1 && arriving[a] == 1;
}

Vector3 Rings::normal(const PointsView& points, int vertex) const
{
    Vector3 middle = points.row(vertex).transpose();
    if (closed_[vertex] && valence(vertex) > 0) {
        middle.setZero();
        for (int a = offsets_[vertex]; a < offsets_[vertex + 1]; ++a)
            middle += points.row(neighbours_[a]).transpose();
        middle /= valence(vertex);
    }
    Vector3 normal = Vector3::Zero();
    for (int c = first_corner_[vertex]; c < first_corner_[vertex + 1]; ++c) {
        const Vector3 a = points.row(neighbours_[corners_[c][0]]).transpose() - middle;
        const Vector3 b = points.row(neighbours_[corners_[c][1]]).transpose() - middle;
        normal += a.cross(b);
    }
    const double length = normal.norm();
    return length > 0 ? Vector3(normal / length) : Vector3::Zero();
}

/// The edges of a ring without their heights.
/// \return false where the ring has no normal.
bool Rings::project(const PointsView& points, int vertex, std::vector<Vector3>& projected) const
{
    const Vector3 N = normal(points, vertex);
    projected.clear();
    for (int a = offsets_[vertex]; a < offsets_[vertex + 1]; ++a) {
        const Vector3 e = edge(points, vertex, neighbours_[a]);
        projected.push_back(e - e.dot(N) * N);
    }
    return N.squaredNorm() > 0.5;
}

Rings::Weights Rings::mean_value_weights(const PointsView& points) const
{
    Weights found;
    found.shares.assign(neighbours_.size(), 0.0);
    std::vector<char> folded(size(), false);
    parallel_chunks(size(), 512, [&](int begin, int end) {
        std::vector<Vector3> flat;
        for (int i = begin; i < end; ++i) {
            const int first = offsets_[i];
            bool usable = closed_[i] && project(points, i, flat);
            if (usable) {
                const Vector3 N = normal(points, i);
                for (int c = first_corner_[i]; c < first_corner_[i + 1]; ++c) {
                    const Vector3 &a = flat[corners_[c][0] - first], &b = flat[corners_[c][1] - first];
                    const double along = a.norm(), beyond = b.norm();
                    const double tangent =
                        a.cross(b).dot(N) / (along * beyond + a.dot(b)); // of half the angle
                    found.shares[corners_[c][0]] += tangent / along;
                    found.shares[corners_[c][1]] += tangent / beyond;
                }
                double sum = 0.0;
                for (int a = first; a < offsets_[i + 1]; ++a)
                    sum += found.shares[a];
                usable = std::isfinite(sum) && sum > 0;
                for (int a = first; a < offsets_[i + 1]; ++a) {
                    found.shares[a] /= sum;
                    usable = usable && found.shares[a] > 0;
                }
                folded[i] = !usable;
            }
            for (int a = first; !usable && a < offsets_[i + 1]; ++a)
                found.shares[a] = 1.0 / valence(i);
        }
    });
    for (int i = 0; i < size(); ++i)
        if (folded[i])
            found.folded.push_back(i);
    return found;
}

Eigen::Quaterniond Rings::turn(const PointsView& from, const PointsView& to, int vertex) const
{
    const Vector3 before = normal(from, vertex), after = normal(to, vertex);
    if (before.isZero() || after.isZero()) {
        Matrix3 covariance = Matrix3::Zero();
        for (int a = offsets_[vertex]; a < offsets_[vertex + 1]; ++a)
            covariance += edge(to, vertex, neighbours_[a]) * edge(from, vertex, neighbours_[a]).transpose();
        return Eigen::Quaterniond(fit_rotation(covariance));
    }
    const Eigen::Quaterniond tilt = smallest_turn(before, after);
    double cosine = 0.0, sine = 0.0;
    for (int a = offsets_[vertex]; a < offsets_[vertex + 1]; ++a) {
        const Vector3 p = tilt * edge(from, vertex, neighbours_[a]), q = edge(to, vertex, neighbours_[a]);
        cosine += p.dot(q) - p.dot(after) * q.dot(after);
        sine += p.cross(q).dot(after);
    }
    return Eigen::AngleAxisd(std::atan2(sine, cosine), after) * tilt;
}

} // namespace sinew
