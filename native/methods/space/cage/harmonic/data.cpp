// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/data.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace sinew {

namespace {

/// The largest distance between the diagonals of a quad that counts as plane, in units of their lengths.
constexpr double plane_quad = 1e-4;

} // namespace

std::vector<HarmonicData> harmonic_data(const Cage& cage)
{
    const SurfaceMesh& rest = cage.rest();
    const auto add = [&](HarmonicData& data, int vertex, int part, double share) {
        if (!cage.smooth()) {
            data.entries.push_back({vertex, part, share});
            return;
        }
        for (SparseRows::InnerIterator entry(cage.smooth()->matrix(), vertex); entry; ++entry)
            data.entries.push_back({static_cast<int>(entry.col()), part, share * entry.value()});
    };
    std::vector<HarmonicData> all;
    all.reserve(cage.triangles().size());
    for (std::size_t t = 0; t < cage.triangles().size(); ++t) {
        const Triangle& triangle = cage.triangles()[t];
        HarmonicData& data = all.emplace_back();
        for (int corner = 0; corner < 3; ++corner)
            add(data, triangle[corner], corner, 1.0);
        const std::span<const int> polygon = rest.face(rest.triangle_faces()[t]);
        if (polygon.size() != 4)
            continue;

        // This is half of a quad; a and c are the ends of the diagonal. If the quad is plane and convex, its
        // data are the hats of its halves, plus a multiple of hat_a hat_c times the affine dependency of its
        // corners. The multiple is the largest one for which no data are negative. On parallelograms, this is
        // the bilinear function.
        const auto at = [&](int v) { return std::find(polygon.begin(), polygon.end(), v) - polygon.begin(); };
        int k = 0;
        while ((at(triangle[k]) - at(triangle[(k + 1) % 3])) % 2 != 0)
            ++k;
        const auto turned = [&](int v, int by) {
            return polygon[static_cast<std::size_t>((at(v) + by) % 4)];
        };
        const int a = triangle[k], c = triangle[(k + 1) % 3], b = turned(a, 1), d = turned(a, 3);
        const auto position = [&](int v) -> Vector3 { return rest.point(v) / cage.size(); };
        const Vector3 ac = position(c) - position(a), bd = position(d) - position(b);
        const Vector3 between = position(b) - position(a), normal = ac.cross(bd);
        const double twist = std::abs(normal.dot(between)) / normal.norm();
        const double alpha = between.cross(bd).dot(normal) / normal.squaredNorm();
        const double beta = between.cross(ac).dot(normal) / normal.squaredNorm();
        if (!(twist < plane_quad * std::min(ac.norm(), bd.norm())) || alpha <= 0.0 || alpha >= 1.0 ||
            beta <= 0.0 || beta >= 1.0)
            continue;
        const double most = 1.0 / std::max(alpha, 1.0 - alpha);
        data.diagonal = k;
        add(data, a, 3, -most * (1.0 - alpha));
        add(data, b, 3, most * (1.0 - beta));
        add(data, c, 3, -most * alpha);
        add(data, d, 3, most * beta);
    }
    return all;
}

} // namespace sinew
