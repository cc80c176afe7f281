// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/gradient.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

SparseMatrix gradient_matrix(const SurfaceMesh& mesh)
{
    const auto& triangles = mesh.triangles();
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * triangles.size());
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
        const Triangle& corner = triangles[t];
        const Vector3 a = mesh.point(corner[1]) - mesh.point(corner[0]);
        const Vector3 b = mesh.point(corner[2]) - mesh.point(corner[0]);
        const Vector3 normal = a.cross(b); // 2 area n
        const double square = normal.squaredNorm();
        if (!(square > 0))
            continue;
        for (int c = 0; c < 3; ++c) {
            // The hat function of corner c rises across the opposite edge e: n x e / (2 area).
            const Vector3 e = mesh.point(corner[(c + 2) % 3]) - mesh.point(corner[(c + 1) % 3]);
            const Vector3 slope = normal.cross(e) / square;
            for (int axis = 0; axis < 3; ++axis)
                entries.emplace_back(3 * t + axis, corner[c], slope[axis]);
        }
    }
    SparseMatrix G(3 * static_cast<int>(triangles.size()), mesh.vertex_count());
    G.setFromTriplets(entries.begin(), entries.end());
    return G;
}

SparseMatrix divergence_matrix(const SurfaceMesh& mesh)
{
    const auto& triangles = mesh.triangles();
    VectorX D(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Triangle& c = triangles[t];
        const Vector3 a = mesh.point(c[1]) - mesh.point(c[0]);
        D.segment<3>(3 * t).setConstant(0.5 * a.cross(mesh.point(c[2]) - mesh.point(c[0])).norm());
    }
    return gradient_matrix(mesh).transpose() * D.asDiagonal();
}

} // namespace sinew
