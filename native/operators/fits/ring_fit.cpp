// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/fits/ring_fit.h"

#include "native/core/dense.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

namespace sinew {

namespace {

constexpr double on_a_line = 1e-9; ///< an eigenvalue below this share of the largest one counts as zero
constexpr double well_posed = 1e-4; ///< a determinant, as a share of a third of the trace cubed

Matrix3 pseudo_inverse(const Matrix3& K)
{
    const double third = K.trace() / 3;
    if (!(third > 0))
        return Matrix3::Zero();
    const Matrix3 scaled = K / third;
    if (scaled.determinant() > well_posed)
        return scaled.inverse() / third;
    const Eigenvectors<3> eigen = eigenvectors(scaled);
    Vector3 inverse = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
        if (eigen.values[k] > on_a_line * eigen.values[2])
            inverse[k] = 1.0 / eigen.values[k];
    return eigen.vectors * (inverse / third).asDiagonal() * eigen.vectors.transpose();
}

} // namespace

Ring ring_at(const SparseMatrix& L, const PointsView& y, int vertex)
{
    Ring ring{y.row(vertex).transpose(), Matrix3::Zero(), 0.0};
    const Vector3 own = ring.mean;
    int count = 0;
    Vector3 sum = Vector3::Zero();
    Matrix3 squares = Matrix3::Zero();
    for (SparseMatrix::InnerIterator it(L, vertex); it; ++it) {
        const Vector3 edge = y.row(it.row()).transpose() - own; // zero for the vertex itself
        sum += edge;
        squares += edge * edge.transpose();
        ++count;
    }
    if (count == 0)
        return ring;
    sum /= count;
    ring.mean += sum;
    squares -= count * sum * sum.transpose();
    const double square = squares.trace();
    ring.inverse = pseudo_inverse(square * Matrix3::Identity() - squares);
    ring.inverse_square = square > 0 ? 1.0 / square : 0.0;
    return ring;
}

Vector3 LinearSimilarity::operator()(const Vector3& v) const { return factor() * v + turn.cross(v); }

Vector3 LinearSimilarity::rotated(const Vector3& v) const
{
    const double sine_square = turn.squaredNorm(), c = factor(), length = std::sqrt(c * c + sine_square);
    if (!(length > 0))
        return v;
    const double along = c > 0 ? 1.0 / (length + c) : sine_square > 0 ? (length - c) / sine_square : 0.0;
    return (c * v + turn.cross(v) + along * turn.dot(v) * turn) / length;
}

LinearSimilarity fit_ring(const SparseMatrix& L, const PointsView& y, const Ring& ring,
                          const double* displacements, int vertex)
{
    const double* const own = displacements + 3 * static_cast<std::ptrdiff_t>(vertex);
    double dot = 0.0;
    Vector3 cross = Vector3::Zero();
    for (SparseMatrix::InnerIterator it(L, vertex); it; ++it) {
        const double* const other = displacements + 3 * it.row();
        const Vector3 r = y.row(it.row()).transpose() - ring.mean,
                      d(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
        dot += r.dot(d);
        cross += r.cross(d);
    }
    return {ring.inverse_square * dot, ring.inverse * cross};
}

} // namespace sinew
