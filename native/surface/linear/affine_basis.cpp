// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/affine_basis.h"

#include "native/core/parallel.h"
#include "native/surface/linear/thin_shell.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

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
    basis_ = response.displacement;
    energy_ = std::move(response.energy);
    residual_ = std::move(response.residual);
    load_ = std::move(response.load);
}

SolveReport AffineBasis::solve(const Poses& poses, Points& positions) const
{
    const int handles = static_cast<int>(basis_.cols()) / 4;
    Targets{poses, view(rest_), {}, nullptr}.check(handles);

    MatrixX P(4 * handles, 3);
    for (int h = 0; h < handles; ++h) {
        P.middleRows<4>(4 * h) = poses[h].transpose();
        P.middleRows<3>(4 * h) -= Matrix3::Identity();
    }
    positions.resize(rest_.rows(), 3);
    parallel_for(static_cast<int>(rest_.rows()), [&](int i) {
        double x = rest_(i, 0), y = rest_(i, 1), z = rest_(i, 2);
        for (int c = 0; c < basis_.cols(); ++c) {
            const double b = basis_(i, c);
            x += b * P(c, 0);
            y += b * P(c, 1);
            z += b * P(c, 2);
        }
        positions.row(i) << x, y, z;
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
