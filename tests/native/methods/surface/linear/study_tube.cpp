// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/surface/linear/study_tube.h"

#include <Eigen/Geometry>

namespace sinew {

SurfaceMesh study_tube()
{
    constexpr int around = 28, along = 80;
    std::vector<Vector3> p;
    shapes::Polygons faces;
    for (int i = 0; i <= along; ++i)
        for (int j = 0; j < around; ++j) {
            const double angle = 2 * shapes::pi * j / around;
            p.emplace_back(20.0 * i / along, std::cos(angle), std::sin(angle));
            if (i == along)
                continue;
            const int a = i * around + j, b = i * around + (j + 1) % around;
            faces.push_back({b + around, b, a});
            faces.push_back({a + around, b + around, a});
        }
    const int first = static_cast<int>(p.size());
    p.emplace_back(0, 0, 0);
    p.emplace_back(20, 0, 0);
    for (int j = 0; j < around; ++j) {
        const int next = (j + 1) % around, last = around * along;
        faces.push_back({first, j, next});
        faces.push_back({first + 1, last + next, last + j});
    }
    return shapes::mesh(p, faces);
}

double rms_edge_ratio(const SurfaceMesh& mesh, const Points& q)
{
    double sum = 0.0;
    const auto edges = mesh.edges();
    for (const auto& [a, b] : edges) {
        const double ratio = (q.row(a) - q.row(b)).norm() / (mesh.point(a) - mesh.point(b)).norm();
        sum += (ratio - 1) * (ratio - 1);
    }
    return std::sqrt(sum / static_cast<double>(edges.size()));
}

double enclosed_volume(const SurfaceMesh& mesh, const Points& q)
{
    double six = 0.0;
    for (const auto& [a, b, c] : mesh.triangles())
        six += q.row(a).cross(q.row(b)).dot(q.row(c));
    return six / 6;
}

Pose study_bend()
{
    const double angle = 2 * shapes::pi / 3, radius = 14 / angle;
    return shapes::turn({0, 1, 0}, -120, {17, 0, 0},
                        {3 + radius * std::sin(angle) - 17, 0, radius * (1 - std::cos(angle))});
}

} // namespace sinew
