// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_sketch.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/mesh/components.h"
#include "native/operators/differential_coordinates.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/solvers/sparse_columns.h"

#include <Eigen/Core>

#include <algorithm>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// How much no rotation at all counts in a fit, as a share of the edges of a vertex: it decides where they
/// leave a rotation open.
constexpr double least_frame = 1e-9;

/// The rotation of the edges at a vertex from x to y.
Matrix3 rotation_at(const SparseMatrix& L, const Points& x, const Points& y, int vertex)
{
    Matrix3 sum = Matrix3::Zero();
    double square = 0.0;
    for (SparseMatrix::InnerIterator it(L, vertex); it; ++it) {
        const Vector3 edge = (x.row(it.row()) - x.row(vertex)).transpose();
        sum += (y.row(it.row()) - y.row(vertex)).transpose() * edge.transpose();
        square += edge.squaredNorm();
    }
    return fit_rotation(sum + least_frame * square * Matrix3::Identity());
}

void check(const SurfaceMesh& rest, const std::vector<LinePoint>& line, const std::vector<int>& held,
           const SilhouetteSketchOptions& options)
{
    require_at_least(options.refits, 0, "refits");
    require_at_least(options.sharpness, -1, "sharpness");
    require_at_least(options.weight, 0, "weight");
    if (options.weight >= 1)
        throw InvalidOption("weight: it is not less than 1");
    const auto require_vertex = [&](int v, const char* name) {
        if (v < 0 || v >= rest.vertex_count())
            throw InvalidConstraint(std::string(name) + ": there is no vertex " + std::to_string(v),
                                    Error::Element::vertex, {v});
    };
    for (int v : held)
        require_vertex(v, "held");
    for (const LinePoint& point : line) {
        require_vertex(point.a, "line");
        require_vertex(point.b, "line");
        if (!(point.share >= 0 && point.share <= 1))
            throw InvalidConstraint("line: a share is not in 0..1");
    }
}

} // namespace

SilhouetteSketch::SilhouetteSketch(const SurfaceMesh& rest, std::vector<LinePoint> line,
                                   const std::vector<int>& held, const SilhouetteSketchOptions& options)
    : options_(options), rest_(rest.points()), line_(std::move(line))
{
    check(rest, line_, held, options);
    const int n = rest.vertex_count();
    std::vector<bool> stays(n, false), moves(n, false);
    for (int v : held)
        stays[v] = true;
    const Components parts = connected_components(rest);
    std::vector<bool> follows(parts.count, false);
    scale_ = VectorX::Ones(n);
    for (const LinePoint& point : line_)
        for (int v : {point.a, point.b}) {
            follows[parts.labels[v]] = follows[parts.labels[v]] || !stays[v];
            scale_[v] = 1 + options.sharpness;
        }
    place_.assign(n, -1);
    for (int v = 0; v < n; ++v)
        if (!stays[v] && follows[parts.labels[v]]) {
            place_[v] = static_cast<int>(free_.size());
            free_.push_back(v);
        }
    if (free_.empty())
        throw InvalidConstraint("line: there is no vertex of it that may move");

    SparseMatrix A;
    {
        const TriangleMetric metric = triangle_metric(rest, least_area_for_order(2));
        L_ = laplacian_matrix(rest, options.laplacian, metric);
        const VectorX mass = divisible_mass(rest, options.laplacian, metric);
        A = sparse_product(L_, mass.cwiseInverse(), L_);
        differentiate(L_, mass, view(rest_), delta_);
    }

    const VectorX diagonal = A.diagonal();
    const double stiffness = options.weight / (1 - options.weight);
    std::vector<std::vector<std::pair<int, double>>> pulls(n); // of each column
    for (const LinePoint& point : line_) {
        const double share = point.a == point.b ? 0.0 : point.share;
        const double s = stiffness * ((1 - share) * diagonal[point.a] + share * diagonal[point.b]);
        const std::pair<int, double> ends[] = {{point.a, 1 - share}, {point.b, share}};
        for (const auto& [v, of_column] : ends)
            for (const auto& [w, of_row] : ends)
                if (of_column * of_row != 0)
                    pulls[v].emplace_back(w, s * of_column * of_row);
        pull_.push_back(s);
    }
    const int unknowns = free_count();
    factor_.factorize(sparse_by_columns(unknowns, unknowns, [&](int c, SparseColumn& column) {
        for (SparseMatrix::InnerIterator it(A, free_[c]); it; ++it)
            if (place_[it.row()] >= 0)
                column.add(place_[it.row()], it.value());
        for (const auto& [row, value] : pulls[free_[c]])
            if (place_[row] >= 0)
                column.add(place_[row], value);
    }));
}

void SilhouetteSketch::solve(const PointsView& targets, Points& positions) const
{
    if (targets.rows() != static_cast<Eigen::Index>(line_.size()))
        throw InvalidConstraint("targets: " + std::to_string(targets.rows()) + " given for " +
                                std::to_string(line_.size()) + " points of the line");
    if (!all_finite(targets))
        throw InvalidConstraint("targets: NaN or infinite coordinates");
    const int n = vertex_count();
    RowMatrix pulled = RowMatrix::Zero(free_count(), 3);
    for (std::size_t k = 0; k < line_.size(); ++k) {
        const LinePoint& point = line_[k];
        const double share = point.a == point.b ? 0.0 : point.share;
        const Vector3 way = targets.row(static_cast<Eigen::Index>(k)).transpose() - point.on(view(rest_));
        const std::pair<int, double> ends[] = {{point.a, 1 - share}, {point.b, share}};
        for (const auto& [v, weight] : ends)
            if (place_[v] >= 0)
                pulled.row(place_[v]) += pull_[k] * weight * way.transpose();
    }
    positions = rest_;
    Points change(n, 3); // c T delta - delta
    for (int k = 0; k <= options_.refits; ++k) {
        parallel_for(n, [&](int v) {
            const Vector3 before = delta_.row(v).transpose();
            const Vector3 after = k > 0 ? Vector3(rotation_at(L_, rest_, positions, v) * before) : before;
            change.row(v) = (scale_[v] * after - before).transpose();
        });
        RowMatrix d = pulled;
        parallel_for(free_count(),
                     [&](int c) { d.row(c) += laplacian_at(L_, change, free_[c]).transpose(); });
        factor_.solve_rows(d);
        for (int c = 0; c < free_count(); ++c)
            positions.row(free_[c]) = rest_.row(free_[c]) + d.row(c);
    }
}

} // namespace sinew
