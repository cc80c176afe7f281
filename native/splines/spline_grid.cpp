// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/spline_grid.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

namespace sinew {

SplineGrid::Seat SplineGrid::seat(double u, double v) const
{
    Seat seat;
    const int column = u_.values(u, seat.u.data()), row = v_.values(v, seat.v.data());
    seat.first = row * columns() + column;
    return seat;
}

void SplineGrid::evaluate(const Seat& seat, const RowMatrix& control, double* value) const
{
    const int order = degree() + 1;
    const auto m = control.cols();
    std::fill_n(value, m, 0.0);
    for (int j = 0; j < order; ++j)
        for (int i = 0; i < order; ++i) {
            const double weight = seat.v[j] * seat.u[i];
            const double* const point =
                control.data() + m * (seat.first + static_cast<Eigen::Index>(j) * columns() + i);
            for (Eigen::Index column = 0; column < m; ++column)
                value[column] += weight * point[column];
        }
}

WeightRows SplineGrid::weights(const std::vector<Seat>& seats) const
{
    const int order = degree() + 1;
    WeightRows rows(static_cast<Eigen::Index>(seats.size()), size());
    rows.reserve(Eigen::VectorXi::Constant(rows.rows(), order * order));
    for (Eigen::Index row = 0; row < rows.rows(); ++row) {
        const Seat& seat = seats[row];
        for (int j = 0; j < order; ++j)
            for (int i = 0; i < order; ++i)
                rows.insert(row, seat.first + j * columns() + i) = seat.v[j] * seat.u[i];
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
