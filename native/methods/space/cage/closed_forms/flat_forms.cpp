// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/flat_forms.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double half_inverse_pi = 0.15915494309189535; // 1 / (2 pi)
/// Distances, in sizes of the cage: mean value interpolates along an edge that is as near as `on`; Green
/// takes the weights of a point `into` further inside if the outline is as near as `touched`.
constexpr double on = 1e-14, touched = 1e-13, into = 1e-12;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

} // namespace

FlatForms::FlatForms(const Cage& cage, const CageGeometry& geometry)
    : geometry_(geometry), x_(cage.outline().x), y_(cage.outline().y), normal_(cage.outline().normal),
      size_(cage.frame().unit() * cage.size())
{
    for (int v = 0; v < cage.vertex_count(); ++v) {
        const Vector3 p = geometry.normalized(cage.rest().point(v));
        points_.emplace_back(p.dot(x_), p.dot(y_));
        level_ += p.dot(normal_) / cage.vertex_count();
    }
    for (const auto& [a, b] : cage.outline().edges) {
        const Vector2 side = points_[static_cast<std::size_t>(b)] - points_[static_cast<std::size_t>(a)];
        if (const double length = side.norm(); length > 0.0)
            edges_.push_back({a, b, side / length, Vector2(side.y(), -side.x()) / length, length});
    }
}

FlatForms::Vector2 FlatForms::flattened(const Vector3& point, double& height) const
{
    const Vector3 x = geometry_.within_reach(geometry_.normalized(point));
    height = x.dot(normal_) - level_;
    return {x.dot(x_), x.dot(y_)};
}

double FlatForms::square_distance(const Edge& edge, const Vector2& x) const
{
    const Vector2 from = x - points_[static_cast<std::size_t>(edge.a)];
    return (from - std::clamp(from.dot(edge.along), 0.0, edge.length) * edge.along).squaredNorm();
}

int FlatForms::nearest(const Vector2& x) const
{
    int found = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int e = 0; e < edge_count(); ++e)
        if (const double square = square_distance(edges_[static_cast<std::size_t>(e)], x); square < least) {
            least = square;
            found = e;
        }
    return found;
}

double FlatForms::winding(const Vector2& x) const
{
    double sum = 0.0;
    for (const Edge& edge : edges_) {
        const Vector2 a = points_[static_cast<std::size_t>(edge.a)] - x,
                      b = points_[static_cast<std::size_t>(edge.b)] - x;
        sum += std::atan2(cross(a, b), a.dot(b));
    }
    return half_inverse_pi * sum;
}

void FlatForms::mean_value(PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    const Eigen::Index vertices = static_cast<Eigen::Index>(points_.size());
    rows.setZero(block.rows(), vertices + 1);
    outside.assign(static_cast<std::size_t>(block.rows()), 0);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        auto row = rows.row(i);
        const Vector2 x = flattened(block.row(i), row[vertices]);
        if (const Edge& edge = edges_[static_cast<std::size_t>(nearest(x))];
            square_distance(edge, x) <= on * on) {
            const double along =
                (x - points_[static_cast<std::size_t>(edge.a)]).dot(edge.along) / edge.length;
            row[edge.b] = std::clamp(along, 0.0, 1.0);
            row[edge.a] = 1.0 - row[edge.b];
            continue;
        }
        for (const Edge& edge : edges_) {
            const Vector2 a = points_[static_cast<std::size_t>(edge.a)] - x,
                          b = points_[static_cast<std::size_t>(edge.b)] - x;
            const double ra = a.norm(), rb = b.norm(), sine = cross(a, b), cosine = a.dot(b);
            // Both are the tangent of half the angle.
            const double tangent = cosine > 0.0 ? sine / (ra * rb + cosine) : (ra * rb - cosine) / sine;
            row[edge.a] += tangent / ra;
            row[edge.b] += tangent / rb;
        }
        double sum = 0.0; // in the order of the vertices: Eigen's order depends on where the row is in memory
        for (Eigen::Index v = 0; v < vertices; ++v)
            sum += row[v];
        row.head(vertices) /= sum;
        outside[static_cast<std::size_t>(i)] = std::round(winding(x)) < 1.0;
    }
}

template <class Row>
void FlatForms::add_green(const Vector2& x, Row&& row) const
{
    const auto times_log = [](double t, double r) { return r > 0.0 ? t * std::log(r) : 0.0; };
    Eigen::Index column = static_cast<Eigen::Index>(points_.size());
    for (const Edge& edge : edges_) {
        const Vector2 a = points_[static_cast<std::size_t>(edge.a)] - x,
                      b = points_[static_cast<std::size_t>(edge.b)] - x;
        const double p = a.dot(edge.outward), from = a.dot(edge.along), to = from + edge.length;
        const double ra = a.norm(), rb = b.norm();
        const double angle = std::atan2(cross(a, b), a.dot(b));
        const double ratio = ra > 0.0 && rb > 0.0 ? p * std::log(rb / ra) : 0.0;
        row[edge.a] += half_inverse_pi * (to * angle - ratio) / edge.length;
        row[edge.b] += half_inverse_pi * (ratio - from * angle) / edge.length;
        row[column++] +=
            half_inverse_pi * (edge.length - p * angle - times_log(to, rb) + times_log(from, ra));
    }
}

template <class Row>
void FlatForms::represent(int e, double sum, const Vector2& vector, Row&& row) const
{
    const Edge& edge = edges_[static_cast<std::size_t>(e)];
    const Vector2 from = vector - sum * points_[static_cast<std::size_t>(edge.a)];
    const double share = from.dot(edge.along) / edge.length;
    row[edge.a] += sum - share;
    row[edge.b] += share;
    row[static_cast<Eigen::Index>(points_.size()) + e] += from.dot(edge.outward);
}

void FlatForms::green(PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    const Eigen::Index vertices = static_cast<Eigen::Index>(points_.size()), last = vertices + edge_count();
    rows.setZero(block.rows(), last + 1);
    outside.assign(static_cast<std::size_t>(block.rows()), 0);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        auto row = rows.row(i);
        const Vector2 x = flattened(block.row(i), row[last]);
        Vector2 outwards = Vector2::Zero();
        for (const Edge& edge : edges_)
            if (square_distance(edge, x) <= touched * touched)
                outwards += edge.outward;
        const Vector2 taken = outwards.isZero(0.0) ? x : Vector2(x - into * outwards.stableNormalized());
        const double times = std::round(winding(taken));
        add_green(taken, row);
        if (times != 0.0)
            row.head(last) /= times;
        outside[static_cast<std::size_t>(i)] = times < 1.0;
        if (times == 0.0)
            represent(nearest(x), 1.0, x, row);
        else if (taken != x)
            represent(nearest(x), 0.0, x - taken, row);
    }
}

void FlatForms::controls(PointsView vertices, bool edges, Eigen::Ref<Points> controls) const
{
    // The area vector, relative to one vertex and in a unit in which nothing overflows.
    const Eigen::RowVector3d origin = vertices.row(edges_.front().a);
    const double scale = (vertices.rowwise() - origin).cwiseAbs().maxCoeff();
    Vector3 area = Vector3::Zero();
    if (scale > 0.0)
        for (const Edge& edge : edges_) {
            const Vector3 a = (vertices.row(edge.a) - origin) / scale,
                          b = (vertices.row(edge.b) - origin) / scale;
            area += a.cross(b);
        }
    const Vector3 normal = area.norm() > 1e-14 ? Vector3(area.normalized()) : Vector3::Zero();
    Eigen::Index row = 0;
    if (edges)
        for (const Edge& edge : edges_) {
            const Vector3 side = vertices.row(edge.b) - vertices.row(edge.a);
            controls.row(row++) = side.cross(normal).transpose() / edge.length;
        }
    controls.row(row) = size_ * normal.transpose();
}

} // namespace sinew
