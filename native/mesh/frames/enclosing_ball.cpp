// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/enclosing_ball.h"

#include "native/core/dense.h"

#include <array>
#include <random>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr double rounding = 1e-12; ///< as a share of the radius

/// Up to four points that lie on the ball.
struct Support
{
    std::array<Vector3, 4> points;
    int count = 0;

    Support() { points.fill(Vector3::Zero()); }
    Support with(const Vector3& point) const
    {
        Support more = *this;
        more.points[more.count++] = point;
        return more;
    }
    /// The smallest ball through them: its centre is p_0 + sum x_k e_k with the edges e_k from p_0, and
    /// 2 e_j . sum x_k e_k = |e_j|^2.
    Ball ball() const
    {
        if (count == 0)
            return {Vector3::Zero(), -1.0};
        if (count == 1)
            return {points[0], 0.0};
        MatrixX edges(3, count - 1);
        for (int k = 1; k < count; ++k)
            edges.col(k - 1) = points[k] - points[0];
        const MatrixX products = transposed_product(edges, edges);
        LeastNorm fit;
        fit.factorize(2.0 * products);
        const Vector3 arm = times(edges, fit.solve(products.diagonal()));
        return {points[0] + arm, arm.norm()};
    }
};

Ball smallest(const std::vector<Vector3>& points, std::size_t count, const Support& support)
{
    Ball ball = support.ball();
    if (support.count == 4)
        return ball;
    for (std::size_t i = 0; i < count; ++i)
        if ((points[i] - ball.centre).norm() > (1.0 + rounding) * ball.radius)
            ball = smallest(points, i, support.with(points[i]));
    return ball;
}

} // namespace

Ball enclosing_ball(const Points& points)
{
    std::vector<Vector3> order;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        order.emplace_back(points.row(i).transpose());
    std::mt19937 random; // NOLINT(bugprone-random-generator-seed,cert-msc51-cpp): the same in each call
    for (std::size_t i = order.size(); i > 1; --i) // std::shuffle differs between libraries
        std::swap(order[i - 1], order[random() % i]);
    return smallest(order, order.size(), {});
}

} // namespace sinew
