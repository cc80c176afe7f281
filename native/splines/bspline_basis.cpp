// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/splines/bspline_basis.h"

#include "native/core/errors.h"

#include <algorithm>
#include <string>

namespace sinew {

BsplineBasis::BsplineBasis(int degree, int count, Ends ends) : degree_(degree), count_(count)
{
    if (degree < 1 || degree > most_spline_degree)
        throw InvalidOption("degree: " + std::to_string(degree) + " is not between 1 and " +
                            std::to_string(most_spline_degree));
    if (count <= degree)
        throw InvalidOption("a spline of degree " + std::to_string(degree) + " needs at least " +
                            std::to_string(degree + 1) + " control points in each direction, not " +
                            std::to_string(count));
    for (int k = 0; k <= count + degree; ++k) {
        const int span = ends == Ends::clamped ? std::clamp(k - degree, 0, spans()) : k - degree;
        knots_.push_back(static_cast<double>(span) / spans());
    }
}

int BsplineBasis::values(double t, double* values) const
{
    t = std::clamp(t, 0.0, 1.0);
    const int span = std::min(static_cast<int>(t * spans()), spans() - 1);
    const double* const knot = knots_.data() + span + degree_; // the span begins here
    std::array<double, most_spline_degree + 1> left, right;
    values[0] = 1.0;
    for (int j = 1; j <= degree_; ++j) {
        left[j] = std::max(0.0, t - knot[1 - j]);
        right[j] = std::max(0.0, knot[j] - t); // rounding may have chosen the span beside t
        double carried = 0.0;
        for (int r = 0; r < j; ++r) {
            const double share = values[r] / (right[r + 1] + left[j - r]);
            values[r] = carried + right[r + 1] * share;
            carried = left[j - r] * share;
        }
        values[j] = carried;
    }
    return span;
}

double BsplineBasis::place(int i) const
{
    double sum = 0.0;
    for (int k = 1; k <= degree_; ++k)
        sum += knots_[i + k];
    return sum / degree_;
}

} // namespace sinew
