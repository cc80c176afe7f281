// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/spline_grid.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

namespace sinew {

SplineGrid::Stencil SplineGrid::stencil(double u, double v) const
{
    Stencil stencil;
    const int column = u_.values(u, stencil.u.data()), row = v_.values(v, stencil.v.data());
    stencil.first = row * columns() + column;
    return stencil;
}

void SplineGrid::evaluate(const Stencil& stencil, const RowMatrix& control, double* value) const
{
    const int order = degree() + 1;
    const auto m = control.cols();
    std::fill_n(value, m, 0.0);
    for (int j = 0; j < order; ++j)
        for (int i = 0; i < order; ++i) {
            const double weight = stencil.v[j] * stencil.u[i];
            const double* const point =
                control.data() + m * (stencil.first + static_cast<Eigen::Index>(j) * columns() + i);
            for (Eigen::Index column = 0; column < m; ++column)
                value[column] += weight * point[column];
        }
}

WeightRows SplineGrid::weights(const std::vector<Stencil>& stencils) const
{
    const int order = degree() + 1;
    WeightRows rows(static_cast<Eigen::Index>(stencils.size()), size());
    rows.reserve(Eigen::VectorXi::Constant(rows.rows(), order * order));
    for (Eigen::Index row = 0; row < rows.rows(); ++row) {
        const Stencil& stencil = stencils[row];
        for (int j = 0; j < order; ++j)
            for (int i = 0; i < order; ++i)
                rows.insert(row, stencil.first + j * columns() + i) = stencil.v[j] * stencil.u[i];
    }
    rows.makeCompressed();
    return rows;
}

MatrixX SplineGrid::bending() const
{
    MatrixX form = MatrixX::Zero(size(), size());
    using Term = std::pair<int, double>;
    const auto add = [&](double factor, std::initializer_list<Term> difference) {
        for (const auto& [a, x] : difference)
            for (const auto& [b, y] : difference)
                form(a, b) += factor * x * y;
    };
    const int w = columns();
    for (int j = 0; j < rows(); ++j)
        for (int i = 0; i < w; ++i) {
            const int at = j * w + i;
            if (i + 2 < w)
                add(1.0, {{at, 1.0}, {at + 1, -2.0}, {at + 2, 1.0}});
            if (j + 2 < rows())
                add(1.0, {{at, 1.0}, {at + w, -2.0}, {at + 2 * w, 1.0}});
            if (i + 1 < w && j + 1 < rows())
                add(2.0, {{at, 1.0}, {at + 1, -1.0}, {at + w, -1.0}, {at + w + 1, 1.0}});
        }
    return form;
}

} // namespace sinew
