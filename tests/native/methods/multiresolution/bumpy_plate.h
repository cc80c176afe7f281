// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/ring_rotations.h"
#include "tests/native/shapes.h"

#include <cmath>

/// The plate with bumps of the study on multiresolution, its base, and the bends of that base.
namespace sinew::bumps {

/// A square of side 10 with four bumps of this height, cut into k x k cells.
inline SurfaceMesh plate(int k, double height = 0.8)
{
    Points p = shapes::grid_points(k, k, 10.0 / k);
    for (int i = 0; i < p.rows(); ++i) {
        const double wave =
            std::max(0.0, std::sin(0.75 * shapes::pi * p(i, 0)) * std::sin(0.75 * shapes::pi * p(i, 1)));
        p(i, 2) = height * wave * wave;
    }
    return shapes::moved(shapes::grid(k, k), p);
}

/// Bends the plane z = 0 about y, from x0 to x1, without stretching it; what is off the plane keeps its
/// distance.
inline Points bent(const Points& points, double degrees, double x0, double x1)
{
    const double angle = degrees * shapes::pi / 180, r = (x1 - x0) / angle;
    Points q(points.rows(), 3);
    for (int i = 0; i < points.rows(); ++i) {
        const double x = points(i, 0), t = std::clamp((x - x0) / (x1 - x0), 0.0, 1.0) * angle,
                     rest = std::max(x - x1, 0.0) + std::min(x - x0, 0.0), s = r - points(i, 2);
        q.row(i) << x0 + s * std::sin(t) + rest * std::cos(t), points(i, 1),
            r - s * std::cos(t) + rest * std::sin(t);
    }
    return q;
}

inline Points detailed(const DetailCoding& coding, const Points& fine, const Points& coarse,
                       const Points& moved, SolveReport* report = nullptr)
{
    Points found;
    SolveReport solved{.converged = true};
    coding.apply({view(fine), view(coarse), view(moved)}, found, solved);
    if (report)
        *report = solved;
    return found;
}

/// How many triangles of x have turned against the normal that their map of the base gives them: where the
/// surface meets itself locally.
inline int turned_faces(const SurfaceMesh& mesh, const Points& coarse, const Points& moved, const Points& x)
{
    int count = 0;
    for (const Triangle& t : mesh.triangles()) {
        const FaceMap map = face_map(view(coarse), view(moved), t);
        const Vector3 n = face_map(view(mesh.points()), view(x), t).normal,
                      n1 = face_map(view(mesh.points()), view(x), t).other_normal;
        count += (map.weighted * n).dot(n1) < 0;
    }
    return count;
}

/// The root of the mean square of (length of an edge / that at rest - 1), over all edges.
inline double rms_edge_ratio(const SurfaceMesh& mesh, const Points& x)
{
    double sum = 0.0;
    const auto edges = mesh.edges();
    for (const auto& [a, b] : edges) {
        const double ratio = (x.row(a) - x.row(b)).norm() / (mesh.point(a) - mesh.point(b)).norm();
        sum += (ratio - 1) * (ratio - 1);
    }
    return std::sqrt(sum / static_cast<double>(edges.size()));
}

} // namespace sinew::bumps
