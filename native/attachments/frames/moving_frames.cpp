// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/moving_frames.h"

#include "native/core/dense.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fits/rotation_fit.h"

#include <array>

namespace sinew {

namespace {

constexpr int corners_each = 4; ///< slots of a triangle, where a patch has few: itself and its corners

/// One of four matrices.
Matrix3 matrix_of(const double* entries, int lane)
{
    Matrix3 matrix;
    for (int k = 0; k < 9; ++k)
        matrix(k / 3, k % 3) = entries[4 * k + lane];
    return matrix;
}

void set_matrix(double (*entries)[4], int lane, const Matrix3& matrix)
{
    for (int k = 0; k < 9; ++k)
        entries[k][lane] = matrix(k / 3, k % 3);
}

/// The inverse, without the directions in which C has no width: there it would return rounding errors.
Matrix3 inverse_of(const Matrix3& C)
{
    const Eigenvectors<3> axes = eigenvectors(C);
    Matrix3 inverse = Matrix3::Zero();
    for (int k = 0; k < 3; ++k)
        if (const double wide = axes.values[k]; wide > 1e-9 * axes.values[2])
            inverse += axes.vectors.col(k) * axes.vectors.col(k).transpose() / wide;
    return inverse;
}

} // namespace

void MovingFrames::add(const std::vector<Triangle>& triangles, const std::vector<double>& weights,
                       const std::vector<double>& anchors)
{
    const int lane = size_++ % 4, count = static_cast<int>(triangles.size());
    if (lane == 0)
        firsts_.push_back(firsts_.back());
    const int first = firsts_[firsts_.size() - 2];
    // Of few triangles the centres alone may lie on a line. With three quarters of the weight there, and the
    // rest on their corners, the sums are those over the surfaces of the triangles.
    const bool few = corners_each * count <= most_triangles;
    const int used = few ? corners_each * count : count;
    while (firsts_.back() < first + used) { // the patches before have no more triangles
        FrameSlot slot = firsts_.back() > first ? slots_[first] : FrameSlot{};
        for (int k = 0; k < 4; ++k)
            slot.weights[k] = slot.anchors[k] = 0.0;
        slots_.push_back(slot);
        ++firsts_.back();
    }
    for (int i = 0; i < firsts_.back() - first; ++i) {
        const int t = i >= used ? 0 : few ? i / corners_each : i;
        const int corner = few && i < used ? i % corners_each : 0; // 0: the triangle itself
        const double share = i >= used ? 0.0 : !few ? 1.0 : corner > 0 ? 1.0 / 12 : 0.75;
        FrameSlot& slot = slots_[first + i];
        for (int other = lane; other < 4; ++other) { // the last four may stay incomplete
            for (int k = 0; k < 3; ++k)
                slot.corners[k][other] = triangles[t][corner > 0 ? corner - 1 : k];
            slot.weights[other] = share * weights[t];
            slot.anchors[other] = share * anchors[t];
        }
    }
}

void MovingFrames::resize(FrameRests& rests) const
{
    rests.arms.resize(slots_.size());
    rests.fours.resize(four_count());
}

void MovingFrames::measure(int four, const PointsView& points, FrameRests& rests) const
{
    measure(four, points, &rests.arms[firsts_[four]], rests.fours[four]);
}

void MovingFrames::measure(int four, const PointsView& points, FrameArms* arms, FourRests& rests) const
{
    const int first = firsts_[four];
    double C[36];
    const int safe = widest_kernels<FrameKernels>().measure(&slots_[first], firsts_[four + 1] - first,
                                                            points.data(), arms, rests, C);
    for (int lane = 0; lane < 4; ++lane)
        if (!(safe >> lane & 1))
            set_matrix(rests.inverse, lane, inverse_of(matrix_of(C, lane)));
}

FourMotions MovingFrames::fit(int four, const FrameRests& rests, const PointsView& points) const
{
    return fit(four, &rests.arms[firsts_[four]], rests.fours[four], points);
}

FourMotions MovingFrames::fit(int four, const PointsView& before, const PointsView& after,
                              FourRests& rests) const
{
    std::array<FrameArms, most_slots> arms;
    measure(four, before, arms.data(), rests);
    return fit(four, arms.data(), rests, after);
}

FourMotions MovingFrames::fit(int four, const FrameArms* arms, const FourRests& rests,
                              const PointsView& points) const
{
    const int first = firsts_[four];
    FourMotions motions;
    double C[36];
    const int safe = widest_kernels<FrameKernels>().fit(&slots_[first], arms, firsts_[four + 1] - first,
                                                        rests, points.data(), motions, C);
    for (int lane = 0; lane < 4; ++lane)
        if (!(safe >> lane & 1))
            set_matrix(motions.rotations, lane, fit_rotation_svd(matrix_of(C, lane)));
    return motions;
}

} // namespace sinew
