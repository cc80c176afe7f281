// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/axis_basis.h"

#include "native/core/errors.h"
#include "native/splines/bspline_basis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace sinew {

namespace {

using Polynomial = std::vector<double>; ///< by rising powers

Polynomial times_line(const Polynomial& p, double constant, double slope)
{
    Polynomial q(p.size() + 1, 0.0);
    for (std::size_t k = 0; k < p.size(); ++k) {
        q[k] += constant * p[k];
        q[k + 1] += slope * p[k];
    }
    return q;
}

double value(const double* coefficients, int degree, double t, double* derivative)
{
    double sum = coefficients[degree], slope = 0.0;
    for (int k = degree - 1; k >= 0; --k) {
        slope = slope * t + sum;
        sum = sum * t + coefficients[k];
    }
    if (derivative)
        *derivative = slope;
    return sum;
}

/// The B-splines of clamped knots on one span, by de Boor's recurrence, as polynomials of the distance from
/// the middle of the span; there, powers of a half keep the coefficients small.
std::vector<Polynomial> on_span(int span, int degree, int spans)
{
    const auto knot = [&](int k) { return static_cast<double>(std::clamp(k - degree, 0, spans)); };
    const double middle = span + 0.5;
    std::vector<Polynomial> functions{{1.0}};
    for (int d = 1; d <= degree; ++d) {
        std::vector<Polynomial> next(functions.size() + 1, Polynomial(static_cast<std::size_t>(d) + 1, 0.0));
        for (int r = 0; r < d; ++r) { // function r of degree d - 1 begins at this knot
            const int begin = span + degree - d + 1 + r;
            const double low = knot(begin), high = knot(begin + d), length = high - low;
            const Polynomial falling = times_line(functions[r], (high - middle) / length, -1.0 / length);
            const Polynomial rising = times_line(functions[r], (middle - low) / length, 1.0 / length);
            for (int k = 0; k <= d; ++k) {
                next[r][k] += falling[k];
                next[r + 1][k] += rising[k];
            }
        }
        functions = std::move(next);
    }
    return functions;
}

} // namespace

AxisBasis::AxisBasis(LatticeBasis basis, int points, int degree, LatticeOutside outside) : points_(points)
{
    if (points < 1)
        throw InvalidOption("a lattice has at least 1 point along each axis, not " + std::to_string(points));
    if (degree < 1 || degree > most_spline_degree)
        throw InvalidOption("degree: " + std::to_string(degree) + " is not between 1 and " +
                            std::to_string(most_spline_degree));
    if (points == 1) {
        pieces_ = {{0, 0.0}};
        coefficients_ = {1.0};
        return;
    }
    if (basis == LatticeBasis::bezier) {
        if (points > most_bezier_points)
            throw InvalidOption("a Bezier lattice has at most " + std::to_string(most_bezier_points) +
                                " points along each axis, not " + std::to_string(points) + ": use B-splines");
        add_spans(points - 1, outside);
    } else if (basis == LatticeBasis::bspline) {
        add_spans(std::min(degree, points - 1), outside);
    } else {
        add_cells(basis);
    }
}

void AxisBasis::add_spans(int degree, LatticeOutside outside)
{
    const int spans = points_ - degree;
    own_parameter_ = true;
    degree_ = degree;
    width_ = degree + 1;
    end_ = spans;
    begin_ = 0.0;
    // A straight line beyond each end, or what the function is at the end.
    const auto add_end = [&](int span, double local, double s) {
        pieces_.push_back({span, s});
        for (const Polynomial& p : on_span(span, degree, spans)) {
            double slope = 0.0;
            Polynomial line(static_cast<std::size_t>(degree) + 1, 0.0);
            line[0] = value(p.data(), degree, local, &slope);
            line[1] = outside == LatticeOutside::follow ? slope : 0.0;
            coefficients_.insert(coefficients_.end(), line.begin(), line.end());
        }
    };
    add_end(0, -0.5, 0.0);
    for (int span = 0; span < spans; ++span) {
        pieces_.push_back({span, span + 0.5});
        for (const Polynomial& p : on_span(span, degree, spans))
            coefficients_.insert(coefficients_.end(), p.begin(), p.end());
    }
    add_end(spans - 1, 0.5, spans);
}

void AxisBasis::add_cells(LatticeBasis basis)
{
    // The functions of four neighbours by powers of the place between the inner two. These are facts about
    // Blender's lattices: cardinal curves have a tension of 0.71.
    using Cubics = std::array<std::array<double, 4>, 4>;
    const auto through = [](double a) -> Cubics {
        return {{{0.0, -a, 2.0 * a, -a},
                 {1.0, 0.0, a - 3.0, 2.0 - a},
                 {0.0, a, 3.0 - 2.0 * a, a - 2.0},
                 {0.0, 0.0, -a, a}}};
    };
    constexpr double sixth = 1.0 / 6.0;
    Cubics cubics;
    switch (basis) {
    case LatticeBasis::cardinal:
        cubics = through(0.71);
        break;
    case LatticeBasis::catmull_rom:
        cubics = through(0.5);
        break;
    case LatticeBasis::linear:
        cubics = {{{0.0}, {1.0, -1.0}, {0.0, 1.0}, {0.0}}};
        break;
    default:
        cubics = {{{sixth, -0.5, 0.5, -sixth},
                   {4.0 * sixth, 0.0, -1.0, 0.5},
                   {sixth, 0.5, 0.5, -0.5},
                   {0.0, 0.0, 0.0, sixth}}};
    }
    degree_ = basis == LatticeBasis::linear ? 1 : 3;
    width_ = std::min(basis == LatticeBasis::linear ? 2 : 4, points_);
    end_ = points_ - 1;
    begin_ = -2.0;
    // From a cell before the one in which the first function ends, where all neighbours are the first point.
    for (int cell = -3; cell <= points_ + 1; ++cell) {
        const int first = std::clamp(basis == LatticeBasis::linear ? cell : cell - 1, 0, points_ - width_);
        pieces_.push_back({first, static_cast<double>(cell)});
        std::vector<double> rows(static_cast<std::size_t>(width_) * (degree_ + 1), 0.0);
        for (int k = 0; k < 4; ++k) {
            const int point = std::clamp(cell - 1 + k, 0, points_ - 1) - first;
            if (point >= 0 && point < width_)
                for (int power = 0; power <= degree_; ++power)
                    rows[static_cast<std::size_t>(point) * (degree_ + 1) + power] += cubics[k][power];
        }
        if (cell == -3 || cell == points_ + 1) { // constant up to rounding: for any distance
            std::fill(rows.begin(), rows.end(), 0.0);
            rows[cell < 0 ? 0 : static_cast<std::size_t>(width_ - 1) * (degree_ + 1)] = 1.0;
        }
        coefficients_.insert(coefficients_.end(), rows.begin(), rows.end());
    }
}

int AxisBasis::piece(double s, double& local) const
{
    const int last = pieces() - 1;
    const double before = std::floor(std::clamp(s - begin_, -1.0, static_cast<double>(last) - 1.0));
    int found = last == 0 ? 0 : static_cast<int>(before) + 1;
    if (own_parameter_ && s == end_)
        found = last - 1; // the end belongs to the last span
    local = s - pieces_[found].origin;
    return found;
}

int AxisBasis::values(double s, double* values, double* derivatives) const
{
    double local;
    const int found = piece(s, local);
    const double* row = coefficients(found);
    for (int i = 0; i < width_; ++i, row += degree_ + 1)
        values[i] = value(row, degree_, local, derivatives ? derivatives + i : nullptr);
    return first(found);
}

double AxisBasis::place(double s, double* derivative) const
{
    if (!own_parameter_) {
        if (derivative)
            *derivative = 1.0;
        return s;
    }
    std::array<double, most_bezier_points> B, slopes;
    const int from = values(s, B.data(), slopes.data());
    double sum = 0.0, slope = 0.0;
    for (int i = 0; i < width_; ++i) {
        sum += B[i] * (from + i);
        slope += slopes[i] * (from + i);
    }
    if (derivative)
        *derivative = slope;
    return sum;
}

double AxisBasis::parameter(double wanted) const
{
    if (!own_parameter_)
        return wanted;
    double slope;
    if (wanted <= 0.0 || wanted >= points_ - 1) { // straight lines, also where the functions are constant
        const bool low = wanted <= 0.0;
        // A point of a span, not of the piece beyond it.
        place(low ? 0.0 : std::nextafter(end_, 0.0), &slope);
        return low ? wanted / slope : end_ + (wanted - (points_ - 1)) / slope;
    }
    if (pieces() == 3) // one span, whose functions are Bernstein polynomials
        return wanted / (points_ - 1);
    // The place rises with the parameter. Newton's steps stay between bounds that close in.
    double low = 0.0, high = end_, s = wanted / (points_ - 1) * end_;
    for (int step = 0; step < 60; ++step) {
        const double error = place(s, &slope) - wanted;
        if (std::abs(error) < 1e-15 * points_)
            break;
        (error > 0.0 ? high : low) = s;
        const double newton = s - error / slope;
        const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
        const bool is_exact = std::abs(next - s) < 1e-15 * end_;
        s = next;
        if (is_exact)
            break;
    }
    return s;
}

} // namespace sinew
