// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/responses/affine_basis.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/core/simd/product_of_eight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace sinew {

namespace {

constexpr int eight = 8; ///< vertices per block

double trace_form(const MatrixX& form, const MatrixX& P)
{
    return std::max(0.0, (P.transpose() * form * P).trace());
}

} // namespace

MatrixX AffineBasis::columns(const Points& rest, const Regions& regions)
{
    const std::vector<Constraint> constraints = regions.constraints();
    MatrixX columns = MatrixX::Zero(constraints.size(), 4 * regions.handle_count());
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const auto [vertex, handle] = constraints[row];
        columns.block<1, 3>(row, 4 * handle) = rest.row(vertex);
        columns(row, 4 * handle + 3) = 1.0;
    }
    return columns;
}

AffineBasis::AffineBasis(const Points& rest, const LinearResponse& response, const Regions& regions)
    : vertex_count_(static_cast<int>(rest.rows())), columns_(static_cast<int>(response.displacement.cols())),
      energy_(response.energy), residual_(response.residual), load_(response.load)
{
    for (int v = 0; v < vertex_count_; ++v)
        (regions.is_idle(v) ? idle_ : moved_).push_back(v);
    idle_rest_ = rest(idle_, Eigen::all);
    const int rows = 3 + columns_, count = static_cast<int>(moved_.size());
    blocks_.resize(static_cast<std::size_t>((count + eight - 1) / eight) * eight * rows);
    parallel_for(count, [&](int i) {
        double* own = blocks_.data() + static_cast<std::size_t>(i / eight) * eight * rows + i % eight;
        for (int c = 0; c < rows; ++c)
            own[eight * c] = c < 3 ? rest(moved_[i], c) : response.displacement(moved_[i], c - 3);
    });
}

RowMatrix AffineBasis::matrix() const
{
    RowMatrix B = RowMatrix::Zero(vertex_count_, columns_);
    const int rows = 3 + columns_;
    for (int i = 0; i < static_cast<int>(moved_.size()); ++i)
        for (int c = 0; c < columns_; ++c)
            B(moved_[i], c) =
                blocks_[static_cast<std::size_t>(i / eight) * eight * rows + eight * (3 + c) + i % eight];
    return B;
}

SolveReport AffineBasis::solve(const Poses& poses, Points& positions, bool idle_too) const
{
    const int handles = columns_ / 4;
    Targets{poses, PointsView(nullptr, vertex_count_, 3), {}, nullptr}.check(handles);

    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> P(columns_, 3);
    for (int h = 0; h < handles; ++h) {
        P.middleRows<4>(4 * h) = poses[h].transpose();
        P.middleRows<3>(4 * h) -= Matrix3::Identity();
    }
    positions.resize(vertex_count_, 3);
    const ProductOfEight& kernels = widest_kernels<ProductOfEight>();
    const int moved_count = static_cast<int>(moved_.size());
    const int block_count = (moved_count + eight - 1) / eight;
    parallel_for(
        block_count,
        [&](int block) {
            std::array<double, 3 * eight> sums;
            kernels.multiply(blocks_.data() + static_cast<std::size_t>(block) * eight * (3 + columns_),
                             columns_, P.data(), sums.data());
            const int begin = eight * block, count = std::min(eight, moved_count - begin);
            const int* const vertices = moved_.data() + begin;
            double* const points = positions.data();
            if (vertices[count - 1] - vertices[0] == count - 1) { // in a row, as almost all are
                double* point = points + 3 * static_cast<std::size_t>(vertices[0]);
                for (int i = 0; i < count; ++i, point += 3)
                    for (int axis = 0; axis < 3; ++axis)
                        point[axis] = sums[eight * axis + i];
                return;
            }
            for (int i = 0; i < count; ++i)
                for (int axis = 0; axis < 3; ++axis)
                    points[3 * static_cast<std::size_t>(vertices[i]) + axis] = sums[eight * axis + i];
        },
        512);
    if (idle_too)
        for (std::size_t i = 0; i < idle_.size(); ++i)
            positions.row(idle_[i]) = idle_rest_.row(static_cast<Eigen::Index>(i));

    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.energy = 0.5 * trace_form(energy_, P);
    const double load = trace_form(load_, P);
    report.residual = load > 0 ? std::sqrt(trace_form(residual_, P) / load) : 0.0;
    return report;
}

} // namespace sinew
