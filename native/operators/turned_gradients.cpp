// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/turned_gradients.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <numeric>

namespace sinew {

TurnedGradients::TurnedGradients(const SurfaceMesh& mesh, const TriangleMetric& metric)
    : triangles_(mesh.triangles()), half_cotan_(metric.half_cotan), offsets_(mesh.vertex_count() + 1, 0),
      corners_(3 * mesh.triangles().size())
{
    for (const Triangle& t : triangles_)
        for (int v : t)
            ++offsets_[v + 1];
    std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for (int corner = 0; corner < static_cast<int>(corners_.size()); ++corner)
        corners_[next[triangles_[corner / 3][corner % 3]]++] = corner;
}

double TurnedGradients::source(const PointsView& y, const Change& change, std::vector<Vector3>& forces,
                               RowMatrix& b) const
{
    forces.resize(2 * triangles_.size()); // of corners 1 and 2; those of a triangle sum to zero
    const double sum = parallel_sum(triangle_count(), [&](int t) {
        const auto [i, j, k] = triangles_[t];
        const auto& [at_i, at_j, at_k] = half_cotan_[t]; // each for the edge opposite
        Vector3 first = (y.row(j) - y.row(i)).transpose(), second = (y.row(k) - y.row(i)).transpose();
        change(t, first, second);
        const Vector3 third = second - first; // from j to k
        forces[2 * t] = at_k * first - at_i * third;
        forces[2 * t + 1] = at_j * second + at_i * third;
        return at_k * first.squaredNorm() + at_j * second.squaredNorm() + at_i * third.squaredNorm();
    });
    parallel_for(static_cast<int>(y.rows()), [&](int v) {
        Vector3 force = Vector3::Zero();
        for (int at = offsets_[v]; at < offsets_[v + 1]; ++at) {
            const int t = corners_[at] / 3, corner = corners_[at] % 3;
            if (corner == 0)
                force -= forces[2 * t] + forces[2 * t + 1];
            else
                force += forces[2 * t + corner - 1];
        }
        b.row(v) = force.transpose();
    });
    return sum;
}

} // namespace sinew
