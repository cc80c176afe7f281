// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/affine_basis.h"

#include "native/core/parallel.h"
#include "native/solvers/lanes.h"
#include "native/surface/linear/thin_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr int strip = 512; ///< vertices whose points wait in the first cache level

/// x, y, z, 1 of a rest point in the four columns of its handle.
MatrixX affine_columns(const ThinShell& shell)
{
    const std::vector<Constraint> constraints = shell.regions().constraints();
    MatrixX columns = MatrixX::Zero(constraints.size(), 4 * shell.regions().handle_count());
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const auto [vertex, handle] = constraints[row];
        columns.block<1, 3>(row, 4 * handle) = shell.rest().points().row(vertex);
        columns(row, 4 * handle + 3) = 1.0;
    }
    return columns;
}

double trace_form(const MatrixX& form, const MatrixX& P)
{
    return std::max(0.0, (P.transpose() * form * P).trace());
}

} // namespace

AffineBasis::AffineBasis(const ThinShell& shell) : rest_(shell.rest().points())
{
    ThinShellResponse response = shell.respond(affine_columns(shell));
    basis_ = std::move(response.displacement);
    energy_ = std::move(response.energy);
    residual_ = std::move(response.residual);
    load_ = std::move(response.load);
}

SolveReport AffineBasis::solve(const Poses& poses, Points& positions) const
{
    const int handles = static_cast<int>(basis_.cols()) / 4;
    Targets{poses, view(rest_), {}, nullptr}.check(handles);

    const int columns = 4 * handles;
    MatrixX P(columns, 3);
    for (int h = 0; h < handles; ++h) {
        P.middleRows<4>(4 * h) = poses[h].transpose();
        P.middleRows<3>(4 * h) -= Matrix3::Identity();
    }
    std::vector<double> minus_P(lane_count * columns, 0.0);
    for (int c = 0; c < columns; ++c)
        for (int axis = 0; axis < 3; ++axis)
            minus_P[lane_count * c + axis] = -P(c, axis);

    positions.resize(rest_.rows(), 3);
    const LaneKernels& kernels = lane_kernels();
    parallel_chunks(static_cast<int>(rest_.rows()), 4 * strip, [&](int chunk_begin, int chunk_end) {
        std::array<double, lane_count * strip> points{};
        for (int begin = chunk_begin; begin < chunk_end; begin += strip) {
            const int count = std::min(strip, chunk_end - begin);
            for (int i = 0; i < count; ++i)
                std::copy_n(rest_.data() + 3 * (begin + i), 3, points.data() + lane_count * i);
            // A row of the basis is a column of the kernel's block.
            kernels.subtract_transposed(basis_.data() + static_cast<std::size_t>(columns) * begin, columns,
                                        count, columns, minus_P.data(), points.data());
            for (int i = 0; i < count; ++i)
                std::copy_n(points.data() + lane_count * i, 3, positions.data() + 3 * (begin + i));
        }
    });

    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.energy = 0.5 * trace_form(energy_, P);
    const double load = trace_form(load_, P);
    report.residual = load > 0 ? std::sqrt(trace_form(residual_, P) / load) : 0.0;
    return report;
}

} // namespace sinew
