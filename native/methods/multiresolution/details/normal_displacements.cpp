// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/normal_displacements.h"

#include "native/core/parallel.h"
#include "native/mesh/trees/closest_triangle.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <optional>

namespace sinew {

namespace {

constexpr int most_steps = 12;
constexpr double outside = 1e-7; ///< how far beyond an edge a foot point may be, as a share of the triangle
constexpr double residual = 1e-10; ///< of a solution, as a share of the longest edge

/// One triangle of the base, with its normals.
struct Patch
{
    Vector3 b0, b1, b2, n0, n1, n2; ///< a corner, and the differences to it
    double length;

    Patch(const Triangle& t, const PointsView& points, const Points& normals)
        : b0(points.row(t[0]).transpose()), b1(points.row(t[1]).transpose() - b0),
          b2(points.row(t[2]).transpose() - b0), n0(normals.row(t[0]).transpose()),
          n1(normals.row(t[1]).transpose() - n0), n2(normals.row(t[2]).transpose() - n0),
          length(std::max(b1.norm(), b2.norm()))
    {
    }

    /// The derivatives of the place by u, v and h.
    Matrix3 slopes(double u, double v, double h) const
    {
        const Vector3 n = n0 + u * n1 + v * n2;
        const double size = n.norm();
        const Vector3 q = n / size;
        Matrix3 J;
        J.col(0) = b1 + h / size * (n1 - n1.dot(q) * q);
        J.col(1) = b2 + h / size * (n2 - n2.dot(q) * q);
        J.col(2) = q;
        return J;
    }

    Vector3 place(double u, double v, double h) const
    {
        return b0 + u * b1 + v * b2 + h * (n0 + u * n1 + v * n2).normalized();
    }

    /// (u, v, h) of x, if the triangle has a normal through it that no neighbouring one meets before.
    std::optional<Vector3> solve(const Vector3& x) const
    {
        Vector3 y(1.0 / 3, 1.0 / 3, 0);
        y[2] = (x - place(y[0], y[1], 0)).dot((n0 + (n1 + n2) / 3).normalized());
        for (int k = 0; k < most_steps; ++k) {
            const Vector3 miss = place(y[0], y[1], y[2]) - x;
            const Matrix3 J = slopes(y[0], y[1], y[2]);
            const double volume = J.determinant();
            if (!std::isfinite(volume) || volume == 0.0)
                return std::nullopt;
            const bool met = miss.norm() <= residual * length;
            const Vector3 step = J.inverse() * miss;
            if (met) {
                // One step more than needed squares what is left.
                const Vector3 last = y - step;
                Vector3 exact = (place(last[0], last[1], last[2]) - x).norm() < miss.norm() ? last : y;
                const bool inside = std::min({exact[0], exact[1], 1 - exact[0] - exact[1]}) >= -outside;
                if (!inside || volume * slopes(exact[0], exact[1], 0).determinant() <= 0)
                    return std::nullopt;
                return exact;
            }
            y[0] -= std::clamp(step[0], -1.0, 1.0);
            y[1] -= std::clamp(step[1], -1.0, 1.0);
            y[2] -= step[2];
            if (!y.allFinite() || std::max(std::abs(y[0]), std::abs(y[1])) > 4)
                return std::nullopt;
        }
        return std::nullopt;
    }
};

} // namespace

NormalDisplacements::NormalDisplacements(const PointsView& fine, const PointsView& coarse,
                                         std::shared_ptr<const RingRotations> rings)
    : rings_(std::move(rings)), foot_points_(fine.rows())
{
    std::vector<char> vectors(fine.rows(), 0);
    const ClosestTriangle closest(coarse, rings_->triangles());
    std::vector<Vector3> of_faces;
    Points normals;
    normals_of(coarse, of_faces, normals);
    parallel_for(
        static_cast<int>(fine.rows()),
        [&](int v) {
            if (fine.row(v) == coarse.row(v))
                return;
            const Vector3 x = fine.row(v).transpose();
            // Its own vertex of the base is not nearer, unless only flat triangles meet there.
            int triangle = closest.to(x, (1 + 1e-9) * (fine.row(v) - coarse.row(v)).norm());
            if (triangle < 0)
                triangle = closest.to(x, INFINITY);
            if (triangle >= 0)
                foot_points_[v] = foot_point_of(x, triangle, coarse, normals);
            vectors[v] = foot_points_[v].triangle < 0;
        },
        64);
    vectors_ = static_cast<int>(std::ranges::count(vectors, 1));
}

NormalDisplacements::FootPoint NormalDisplacements::foot_point_of(const Vector3& x, int closest,
                                                                  const PointsView& coarse,
                                                                  const Points& normals) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    FootPoint best;
    const auto look = [&](int t) {
        const auto found = Patch(triangles[t], coarse, normals).solve(x);
        if (found && (best.triangle < 0 || std::abs((*found)[2]) < std::abs(best.height)))
            best = {t, (*found)[0], (*found)[1], (*found)[2]};
    };
    look(closest);
    std::vector<int> seen{closest};
    for (std::size_t ring = 0, begin = 0; ring < 2 && best.triangle < 0; ++ring) {
        const std::size_t end = seen.size();
        for (std::size_t k = begin; k < end; ++k)
            for (int v : triangles[seen[k]])
                for (int t : rings_->around(v))
                    if (std::ranges::find(seen, t) == seen.end()) {
                        seen.push_back(t);
                        look(t);
                    }
        begin = end;
    }
    return best;
}

void NormalDisplacements::normals_of(const PointsView& points, std::vector<Vector3>& of_faces,
                                     Points& normals) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    of_faces.resize(triangles.size());
    parallel_for(static_cast<int>(triangles.size()), [&](int t) {
        const auto [i, j, k] = triangles[t];
        const Vector3 a = (points.row(j) - points.row(i)).transpose(),
                      b = (points.row(k) - points.row(i)).transpose();
        of_faces[t] = a.cross(b);
    });
    normals.resize(points.rows(), 3);
    parallel_for(static_cast<int>(points.rows()), [&](int v) {
        Vector3 sum = Vector3::Zero();
        for (int t : rings_->around(v))
            sum += of_faces[t];
        const double length = sum.norm();
        normals.row(v) = (length > 0 ? Vector3(sum / length) : Vector3::Zero()).transpose();
    });
}

Vector3 NormalDisplacements::place_of(const FootPoint& foot_point, const PointsView& points,
                                      const Points& normals) const
{
    const auto [i, j, k] = rings_->triangles()[foot_point.triangle];
    const double first = 1 - foot_point.u - foot_point.v;
    const Vector3 n =
        (first * normals.row(i) + foot_point.u * normals.row(j) + foot_point.v * normals.row(k)).transpose();
    const double size = n.norm();
    const double height = size > 0 ? foot_point.height / size : 0.0;
    return (first * points.row(i) + foot_point.u * points.row(j) + foot_point.v * points.row(k)).transpose() +
           height * n;
}

void NormalDisplacements::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    normals_of(band.moved, work->of_faces, work->normals);
    detailed = band.moved;
    parallel_for(static_cast<int>(foot_points_.size()), [&](int v) {
        if (foot_points_[v].triangle >= 0)
            detailed.row(v) = place_of(foot_points_[v], band.moved, work->normals).transpose();
    });
    if (band.at_rest && vectors_ == 0)
        return;
    // What no height holds: whole details, and what a shape that enters adds to heights.
    if (!band.at_rest)
        normals_of(band.coarse, work->of_faces, work->entering_normals);
    const auto left = [&](int v) -> Vector3 {
        const Vector3 foot = foot_points_[v].triangle < 0
                                 ? Vector3(band.coarse.row(v).transpose())
                                 : place_of(foot_points_[v], band.coarse, work->entering_normals);
        return band.fine.row(v).transpose() - foot;
    };
    rings_->fit(
        band.coarse, band.moved, work->maps,
        [&](int v) {
            return foot_points_[v].triangle < 0 ? band.fine.row(v) != band.coarse.row(v) : !band.at_rest;
        },
        [&](int v, const Matrix3& R, const Matrix3& /*sum*/) {
            detailed.row(v) += (R * left(v)).transpose();
        });
}

} // namespace sinew
