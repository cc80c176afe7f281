// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf/polynomials.h"

#include "native/core/dense.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew {

namespace {

/// Points extend in a direction if they do so by this share of their largest extent.
constexpr double flat = 1e-6;
/// A polynomial vanishes if its values are this share of those of others.
constexpr double vanishing = 1e-7;

} // namespace

Polynomials::Polynomials(const Points& points, int degree) : asked_(degree)
{
    if (degree < 0)
        return;
    centre_ = points.colwise().mean().transpose();
    const Points around = points.rowwise() - centre_.transpose();
    const Eigenvectors<3> eigen = eigenvectors(Matrix3(around.transpose() * around));
    const double largest = std::sqrt(std::max(0.0, eigen.values[2]));
    dimensions_ = 0;
    while (dimensions_ < 3 && largest > 0.0 &&
           (around * eigen.vectors.col(2 - dimensions_)).norm() > flat * largest)
        ++dimensions_;
    if (dimensions_ < 3)
        for (int k = 0; k < 3; ++k)
            axes_.row(k) = eigen.vectors.col(2 - k).transpose();
    for (set_degree(degree); degree_ > 0; set_degree(degree_ - 1)) {
        if (points.rows() < count_)
            continue;
        LeastNorm fit;
        fit.factorize(evaluate(points), vanishing);
        if (fit.rank() == count_)
            break;
    }
}

void Polynomials::set_degree(int degree)
{
    degree_ = degree;
    const int d = dimensions_;
    count_ = degree < 0 ? 0 : 1 + (degree > 0 ? d : 0) + (degree > 1 ? d * (d + 1) / 2 : 0);
}

void Polynomials::evaluate(const double* places, double* values) const
{
    using Values = Eigen::Array<double, 8, 1>;
    const auto next = [&values](const Values& value) {
        Values::Map(values) = value;
        values += 8;
    };
    if (degree_ < 0)
        return;
    next(Values::Ones());
    if (degree_ < 1)
        return;
    std::array<Values, 3> u, from;
    for (int k = 0; k < 3; ++k)
        from[k] = Values::Map(places + 8 * k) - centre_[k];
    for (int k = 0; k < dimensions_; ++k)
        next(u[k] = axes_(k, 0) * from[0] + axes_(k, 1) * from[1] + axes_(k, 2) * from[2]);
    if (degree_ > 1)
        for (int k = 0; k < dimensions_; ++k)
            for (int l = k; l < dimensions_; ++l)
                next(u[k] * u[l]);
}

RowMatrix Polynomials::evaluate(const Points& points) const
{
    RowMatrix values(points.rows(), count_);
    Eigen::Matrix<double, 8, 3> places = decltype(places)::Zero();
    Eigen::Matrix<double, 8, most> some;
    for (Eigen::Index i = 0; i < points.rows(); i += 8) {
        const Eigen::Index rows = std::min<Eigen::Index>(8, points.rows() - i);
        places.topRows(rows) = points.middleRows(i, rows);
        evaluate(places.data(), some.data());
        values.middleRows(i, rows) = some.topLeftCorner(rows, count_);
    }
    return values;
}

std::string Polynomials::remark() const
{
    static constexpr const char* places[] = {"at one place", "on a line", "in a plane"};
    static constexpr const char* shape[] = {"translations", "affine maps", "quadratic maps"};
    if (asked_ < 0)
        return "";
    std::string text;
    if (dimensions_ < 3 && asked_ > 0)
        text = std::string("the handle points lie ") + places[dimensions_] +
               ": maps across it are not carried, and space moves there as the nearest place in it";
    if (degree_ < asked_ && !(dimensions_ == 0)) {
        text += text.empty() ? "the handle points carry no " : "; within it they carry no ";
        text += std::string(shape[degree_ + 1]) + ": " + shape[degree_] + " are used instead";
    }
    return text;
}

LagrangeBase::LagrangeBase(const MatrixX& P) : lagrange(P.rows(), P.cols()), inverse(P.cols(), P.cols())
{
    if (P.cols() == 0)
        return;
    const int count = static_cast<int>(P.cols());
    LeastNorm fit;
    fit.factorize(P.transpose());
    MatrixX own(count, count);
    for (int k = 0; k < count; ++k) {
        points.push_back(fit.column(k));
        own.row(k) = P.row(points.back());
    }
    fit.factorize(own);
    for (int k = 0; k < count; ++k)
        inverse.col(k) = fit.solve(VectorX::Unit(count, k));
    lagrange = product(P, inverse);
}

} // namespace sinew
