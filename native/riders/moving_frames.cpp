// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/moving_frames.h"

#include "native/operators/rotation_fit.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr int slots = MovingFrames::most_triangles;
using Numbers = FrameRest::Numbers;

/// The triangles of a patch in one shape.
struct Surface
{
    std::array<Numbers, 3> centres; ///< from the first one
    std::array<Numbers, 3> normals; ///< of length `areas`
    Numbers areas;                  ///< doubled
    Vector3 first;
};

/// \param corners  three arrays of vertices.
template <class Corners>
void measure(const Corners& corners, const PointsView& points, Surface& surface)
{
    std::array<std::array<Numbers, 3>, 3> x; // one array per corner and coordinate
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < slots; ++i) {
            const double* point = points.data() + 3 * static_cast<std::ptrdiff_t>(corners[k][i]);
            for (int c = 0; c < 3; ++c)
                x[k][c][i] = point[c];
        }
    for (int c = 0; c < 3; ++c) {
        const double from = x[0][c][0];
        surface.first[c] = from;
        for (int i = 0; i < slots; ++i)
            surface.centres[c][i] = ((x[0][c][i] - from) + (x[1][c][i] - from) + (x[2][c][i] - from)) / 3;
    }
    for (int c = 0; c < 3; ++c) {
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        for (int i = 0; i < slots; ++i)
            surface.normals[c][i] = (x[1][a][i] - x[0][a][i]) * (x[2][b][i] - x[0][b][i]) -
                                    (x[1][b][i] - x[0][b][i]) * (x[2][a][i] - x[0][a][i]);
    }
    for (int i = 0; i < slots; ++i)
        surface.areas[i] = std::sqrt(surface.normals[0][i] * surface.normals[0][i] +
                                     surface.normals[1][i] * surface.normals[1][i] +
                                     surface.normals[2][i] * surface.normals[2][i]);
}

/// Moves the origin of the centres to their weighted mean. \return the point at the anchors' mean.
Vector3 centre(Surface& surface, const Numbers& weights, const Numbers& anchors)
{
    Vector3 mean = Vector3::Zero();
    for (int i = 0; i < slots; ++i)
        for (int c = 0; c < 3; ++c)
            mean[c] += weights[i] * surface.centres[c][i];
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < slots; ++i)
            surface.centres[c][i] -= mean[c];
    for (int i = 0; i < slots; ++i)
        for (int c = 0; c < 3; ++c)
            mean[c] += anchors[i] * surface.centres[c][i];
    return surface.first + mean;
}

/// sum a b^T.
Matrix3 products(const std::array<Numbers, 3>& a, const std::array<Numbers, 3>& b)
{
    Matrix3 sum = Matrix3::Zero();
    for (int i = 0; i < slots; ++i) // nine sums side by side: one after the other, each waits for itself
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                sum(r, c) += a[r][i] * b[c][i];
    return sum;
}

/// The inverse, without the directions in which C has no width: there it would return rounding errors.
Matrix3 inverse_of(const Matrix3& C)
{
    const Eigen::SelfAdjointEigenSolver<Matrix3> axes(C);
    Matrix3 inverse = Matrix3::Zero();
    for (int k = 0; k < 3; ++k)
        if (const double wide = axes.eigenvalues()[k]; wide > 1e-9 * axes.eigenvalues()[2])
            inverse += axes.eigenvectors().col(k) * axes.eigenvectors().col(k).transpose() / wide;
    return inverse;
}

double log_scale_of(const Matrix3& gradient)
{
    Eigen::SelfAdjointEigenSolver<Matrix3> solver;
    solver.computeDirect(gradient.transpose() * gradient, Eigen::EigenvaluesOnly);
    constexpr double least = 1e-18; // of a squared scale: a patch that collapsed
    const double low = std::log(std::max(solver.eigenvalues()[0], least)) / 2;
    const double high = std::log(std::max(solver.eigenvalues()[2], least)) / 2;
    const double spread = (high - low) / 2;
    return std::max(0.0, low - spread) + std::min(0.0, high + spread);
}

} // namespace

void MovingFrames::add(const std::vector<Triangle>& triangles, const std::vector<double>& weights,
                       const std::vector<double>& anchors)
{
    Slots patch;
    const int count = static_cast<int>(triangles.size());
    // Of few triangles the centres alone may lie on a line. With three quarters of the weight there, and the
    // rest on their corners, the sums are those over the surfaces of the triangles.
    const bool few = 4 * count <= slots;
    for (int i = 0; i < slots; ++i) {
        const int t = few ? (i / 4 < count ? i / 4 : 0) : (i < count ? i : 0);
        const bool used = few ? i / 4 < count : i < count;
        const int corner = few ? i % 4 : 0; // 0: the triangle itself
        for (int k = 0; k < 3; ++k)
            patch.corners[k][i] = triangles[t][corner > 0 && used ? corner - 1 : k];
        const double share = !used ? 0.0 : !few ? 1.0 : corner > 0 ? 1.0 / 12 : 0.75;
        patch.weights[i] = share * weights[t];
        patch.anchors[i] = share * anchors[t];
    }
    patches_.push_back(patch);
}

FrameRest MovingFrames::rest(int frame, const PointsView& points, const Vector3& origin) const
{
    const Slots& patch = patches_[frame];
    Surface surface;
    measure(patch.corners, points, surface);
    FrameRest rest;
    rest.origin = origin;
    rest.anchor = centre(surface, patch.weights, patch.anchors);
    rest.areas = surface.areas;
    double spread = 0.0;
    for (int i = 0; i < slots; ++i)
        for (int c = 0; c < 3; ++c)
            spread += patch.weights[i] * surface.centres[c][i] * surface.centres[c][i];
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < slots; ++i) {
            const double w = patch.weights[i], area = surface.areas[i];
            rest.arms[c][i] = spread > 1e-290 ? w * surface.centres[c][i] / spread : 0.0;
            surface.normals[c][i] = area > 0.0 ? surface.normals[c][i] / area : 0.0;
            rest.normals[c][i] = 0.5 * w * surface.normals[c][i];
        }
    rest.inverse = inverse_of(products(surface.centres, rest.arms) + products(surface.normals, rest.normals));
    return rest;
}

FrameMotion MovingFrames::move(int frame, const FrameRest& rest, const PointsView& points) const
{
    const Slots& patch = patches_[frame];
    Surface surface;
    measure(patch.corners, points, surface);
    const Vector3 anchor = centre(surface, patch.weights, patch.anchors);
    Numbers scales; // from |normal| = 2 A' to sqrt(A' / A)
    for (int i = 0; i < slots; ++i) {
        const double product = surface.areas[i] * rest.areas[i];
        scales[i] = product > 1e-290 ? 1 / std::sqrt(product) : 0.0;
    }
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < slots; ++i)
            surface.normals[c][i] *= scales[i];
    const Matrix3 C = products(surface.centres, rest.arms) + products(surface.normals, rest.normals);
    FrameMotion motion;
    motion.rotation = fit_rotation(C);
    motion.log_scale = log_scale_of(C * rest.inverse);
    motion.origin = rest.origin;
    motion.place =
        anchor + std::exp(motion.log_scale) * (motion.rotation * (rest.origin - rest.anchor)).eval();
    return motion;
}

} // namespace sinew
