// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/space/cage/cages.h"

namespace sinew {

Points warped_by(const SpaceMethod& method, PointsView control, const std::optional<PointsView>& incoming)
{
    Points out(method.points().rows(), 3);
    method.warp(control, incoming, out.data());
    return out;
}

} // namespace sinew

namespace sinew::shapes {

SurfaceMesh u_prism()
{
    const std::vector<Vector3> outline{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0},
                                       {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    std::vector<Vector3> p = outline;
    for (const Vector3& low : outline)
        p.push_back(low + Vector3(0, 0, 1));
    Polygons faces{{7, 6, 5, 4, 3, 2, 1, 0}, {8, 9, 10, 11, 12, 13, 14, 15}};
    for (int i = 0; i < 8; ++i)
        faces.push_back({i, (i + 1) % 8, 8 + (i + 1) % 8, 8 + i});
    return mesh(p, faces);
}

SurfaceMesh bumpy_sphere(int level, double bumps)
{
    const SurfaceMesh round = sphere(level);
    return moved(round, Random(11).shaken(round.points(), bumps));
}

Points points_around(const SurfaceMesh& cage, int count, double reach, std::uint64_t seed)
{
    const Eigen::RowVector3d low = cage.points().colwise().minCoeff(),
                             high = cage.points().colwise().maxCoeff();
    Random random(seed);
    Points p(count, 3);
    for (int i = 0; i < count; ++i)
        p.row(i) = 0.5 * (low + high) + 0.5 * reach * (high - low).cwiseProduct(random.vector().transpose());
    return p;
}

Points points_near(const SurfaceMesh& cage, const std::vector<double>& distances)
{
    Random random(3);
    std::vector<Vector3> p;
    for (const Triangle& t : cage.triangles()) {
        const Vector3 a = cage.point(t[0]), b = cage.point(t[1]), c = cage.point(t[2]);
        const Vector3 normal = (b - a).cross(c - a).normalized();
        const double s = 0.1 + 0.8 * random.unit(), r = 0.1 + 0.8 * random.unit();
        for (const double d : distances) {
            const Vector3 away = d * (normal + 0.3 * random.vector());
            for (const double side : {-1.0, 1.0}) {
                p.push_back(a + side * away);
                p.push_back(a + s * (b - a) + side * away);
                p.push_back(a + s * (r * b + (1 - r) * c - a) + side * away);
                p.push_back(a + (1 + s) * (b - a) + side * away); // beyond an edge, on its line
                p.push_back(a + (1 + s) * (b - a) + r * (c - a) +
                            side * away); // beyond the triangle, in its plane
            }
        }
    }
    return points_of(p);
}

} // namespace sinew::shapes

namespace sinew::cages {

Points inside_u_prism(int count, double depth)
{
    shapes::Random random(1);
    Points points(count, 3);
    for (int i = 0; i < count;) {
        const Vector3 p(3 * random.unit(), 3 * random.unit(), random.unit());
        const bool in_box =
            p.minCoeff() > depth && p.x() < 3 - depth && p.y() < 3 - depth && p.z() < 1 - depth;
        if (in_box && !(p.x() > 1 - depth && p.x() < 2 + depth && p.y() > 1 - depth))
            points.row(i++) = p.transpose();
    }
    return points;
}

} // namespace sinew::cages
