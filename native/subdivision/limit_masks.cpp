// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/limit_masks.h"

#include "native/core/types.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace sinew {

namespace {

constexpr double endless = 10.0;
constexpr int squarings = 8; // 2^8 steps; each multiplies the distance from the limit by 0.7 at most

double left_after_a_level(double sharpness)
{
    return sharpness >= endless ? sharpness : std::max(0.0, sharpness - 1.0);
}

/// One step of subdivision around a vertex. A row has the weights of one point of the next level: those of
/// the vertex, of its neighbours along edges, and of those across faces.
class Step
{
public:
    explicit Step(const Neighbourhood& around)
        : around_(around), edges_(static_cast<int>(around.edge_sharpness.size())),
          size_(1 + edges_ + (around.triangles ? 0 : around.faces))
    {
    }

    MatrixX matrix() const
    {
        MatrixX step(size_, size_);
        step.row(0) = vertex();
        for (int k = 0; k < edges_; ++k) {
            const double sharp = std::min(around_.edge_sharpness[k], 1.0);
            step.row(1 + k) = sharp * (0.5 * (at(0) + at(1 + k)));
            if (sharp < 1.0)
                step.row(1 + k) += (1.0 - sharp) * smooth_edge(k);
        }
        for (int k = 1 + edges_; k < size_; ++k)
            step.row(k) = face(k - 1 - edges_);
        return step;
    }

private:
    using Row = Eigen::RowVectorXd;

    Row at(int point) const { return Row::Unit(size_, point); }
    int before(int k) const { return (k + edges_ - 1) % edges_; }
    int after(int k) const { return (k + 1) % edges_; }

    Row face(int k) const { return 0.25 * (at(0) + at(1 + k) + at(1 + after(k)) + at(1 + edges_ + k)); }

    /// The point on an edge with two faces; the edges of borders are sharp.
    Row smooth_edge(int k) const
    {
        if (around_.triangles)
            return 0.375 * (at(0) + at(1 + k)) + 0.125 * (at(1 + before(k)) + at(1 + after(k)));
        return 0.25 * (at(0) + at(1 + k) + face(before(k)) + face(k));
    }

    Row smooth_vertex() const
    {
        const double n = edges_;
        Row sum = Row::Zero(size_);
        sum.segment(1, edges_).setOnes();
        if (around_.triangles) {
            const double c = 0.375 + 0.25 * std::cos(2.0 * std::numbers::pi / n);
            const double beta = (0.625 - c * c) / n;
            return (1.0 - n * beta) * at(0) + beta * sum;
        }
        for (int k = 0; k < around_.faces; ++k)
            sum += face(k);
        return (n - 2.0) / n * at(0) + sum / (n * n);
    }

    /// The vertex, by the rule for the edges that have any sharpness.
    Row vertex_by(double sharpness, const std::vector<double>& edges) const
    {
        const auto sharp_edges = std::ranges::count_if(edges, [](double s) { return s > 0.0; });
        if (sharpness > 0.0 || sharp_edges > 2)
            return at(0);
        if (sharp_edges < 2)
            return smooth_vertex();
        Row row = 0.75 * at(0);
        for (int k = 0; k < edges_; ++k)
            if (edges[k] > 0.0)
                row += 0.125 * at(1 + k);
        return row;
    }

    /// The vertex, by the rule of this level. Where sharpnesses end before the next level, this rule is
    /// blended with that of the next level by the mean of these sharpnesses.
    Row vertex() const
    {
        std::vector<double> next;
        double ending = 0.0, count = 0.0;
        const auto pass = [&](double sharpness) {
            const double left = left_after_a_level(sharpness);
            if (sharpness > 0.0 && left == 0.0) {
                ending += std::min(sharpness, 1.0);
                count += 1.0;
            }
            return left;
        };
        for (double s : around_.edge_sharpness)
            next.push_back(pass(s));
        const double next_sharpness = pass(around_.sharpness);
        Row now = vertex_by(around_.sharpness, around_.edge_sharpness);
        if (count == 0.0)
            return now;
        const double share = ending / count;
        return share * now + (1.0 - share) * vertex_by(next_sharpness, next);
    }

    const Neighbourhood& around_;
    int edges_, size_;
};

} // namespace

std::vector<double> limit_mask(const Neighbourhood& around)
{
    std::vector<MatrixX> steps;
    Neighbourhood level = around;
    for (;;) {
        steps.push_back(Step(level).matrix());
        Neighbourhood next = level;
        next.sharpness = left_after_a_level(level.sharpness);
        for (double& s : next.edge_sharpness)
            s = left_after_a_level(s);
        if (next.sharpness == level.sharpness && next.edge_sharpness == level.edge_sharpness)
            break;
        level = std::move(next);
    }
    MatrixX last = std::move(steps.back());
    steps.pop_back();
    for (int k = 0; k < squarings; ++k)
        last = MatrixX(last * last);
    Eigen::RowVectorXd mask = last.row(0);
    for (auto step = steps.rbegin(); step != steps.rend(); ++step)
        mask = Eigen::RowVectorXd(mask * *step);
    mask /= mask.sum(); // after 256 steps, the weights sum to 1 up to rounding only
    return {mask.data(), mask.data() + mask.size()};
}

} // namespace sinew
