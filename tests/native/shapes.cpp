// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/shapes.h"

#include <numeric>

namespace sinew::shapes {

Vector3 Random::vector()
{
    const double x = signed_unit();
    const double y = signed_unit();
    return {x, y, signed_unit()};
}

Matrix3 Random::rotation()
{
    const Vector3 axis = vector();
    return Eigen::AngleAxisd(pi * unit(), axis.normalized()).toRotationMatrix();
}

MatrixX Random::dense(int rows, int columns)
{
    MatrixX m(rows, columns);
    for (Eigen::Index k = 0; k < m.size(); ++k)
        m(k) = signed_unit();
    return m;
}

std::vector<int> Random::shuffled(int count)
{
    std::vector<int> order = numbers(0, count);
    for (int i = count - 1; i > 0; --i)
        std::swap(order[i], order[below(i + 1)]);
    return order;
}

Points Random::points(int count, double reach)
{
    Points found(count, 3);
    for (int i = 0; i < count; ++i)
        found.row(i) = reach * vector().transpose();
    return found;
}

Points Random::shaken(Points points, double by)
{
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        points.row(i) += by * vector().transpose();
    return points;
}

Points points_of(const std::vector<Vector3>& list)
{
    Points points(list.size(), 3);
    for (std::size_t i = 0; i < list.size(); ++i)
        points.row(i) = list[i].transpose();
    return points;
}

std::vector<Vector3> list_of(const Points& points)
{
    std::vector<Vector3> list;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        list.emplace_back(points.row(i).transpose());
    return list;
}

std::vector<int> numbers(int begin, int end)
{
    std::vector<int> all(end - begin);
    std::iota(all.begin(), all.end(), begin);
    return all;
}

SurfaceMesh over(const Points& points, const Polygons& faces)
{
    std::vector<int> counts, corners;
    for (const auto& face : faces) {
        counts.push_back(static_cast<int>(face.size()));
        corners.insert(corners.end(), face.begin(), face.end());
    }
    return {points, std::move(counts), std::move(corners)};
}

SurfaceMesh mesh(const std::vector<Vector3>& points, const Polygons& faces)
{
    return over(points_of(points), faces);
}

Polygons faces_of(const SurfaceMesh& of)
{
    Polygons faces;
    for (int f = 0; f < of.face_count(); ++f)
        faces.emplace_back(of.face(f).begin(), of.face(f).end());
    return faces;
}

SurfaceMesh moved(const SurfaceMesh& of, const Points& points) { return over(points, faces_of(of)); }

SurfaceMesh flipped(const SurfaceMesh& of, const std::vector<int>& faces)
{
    Polygons all = faces_of(of);
    for (int f : faces)
        std::ranges::reverse(all[f]);
    return over(of.points(), all);
}

SurfaceMesh inside_out(const SurfaceMesh& of) { return flipped(of, numbers(0, of.face_count())); }

SurfaceMesh without_face(const SurfaceMesh& of, int face)
{
    Polygons faces = faces_of(of);
    faces.erase(faces.begin() + face);
    return over(of.points(), faces);
}

SurfaceMesh octahedron()
{
    return mesh({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}

SurfaceMesh cube()
{
    return mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

Points grid_points(int columns, int rows, double spacing, double jitter)
{
    Random random(7);
    std::vector<Vector3> p;
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const bool inner = i > 0 && j > 0 && i < columns && j < rows;
            const Vector3 move = random.vector() * (inner ? jitter : 0.0);
            p.emplace_back(spacing * (i + move.x()), spacing * (j + move.y()), 0);
        }
    return points_of(p);
}

SurfaceMesh quad_grid(int columns, int rows, double spacing)
{
    Polygons faces;
    const auto v = [&](int i, int j) { return j * (columns + 1) + i; };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            faces.push_back({v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)});
    return over(grid_points(columns, rows, spacing), faces);
}

SurfaceMesh grid(int columns, int rows, double spacing, double jitter)
{
    Polygons faces;
    for (const std::vector<int>& quad : faces_of(quad_grid(columns, rows))) {
        const bool rising = (quad[0] / (columns + 1) + quad[0] % (columns + 1)) % 2;
        faces.push_back({quad[0], quad[1], quad[rising ? 2 : 3]});
        faces.push_back({quad[rising ? 0 : 1], quad[2], quad[3]});
    }
    return over(grid_points(columns, rows, spacing, jitter), faces);
}

SurfaceMesh hill(int columns, int rows)
{
    Points p = grid_points(columns, rows, 1.0, 0.2);
    for (int i = 0; i < p.rows(); ++i)
        p(i, 2) = 0.1 * columns * std::sin(3.0 * p(i, 0) / columns) * std::cos(2.0 * p(i, 1) / rows) +
                  0.02 * p(i, 0);
    return moved(grid(columns, rows), p);
}

SurfaceMesh sphere(int level)
{
    const SurfaceMesh start = octahedron();
    std::vector<Vector3> p = list_of(start.points());
    std::vector<Triangle> triangles = start.triangles();
    for (int k = 0; k < level; ++k) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<int>(p.size()));
            if (fresh)
                p.push_back((p[a] + p[b]).normalized());
            return at->second;
        };
        std::vector<Triangle> finer;
        for (const auto& [a, b, c] : triangles) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    Polygons faces;
    for (const Triangle& t : triangles)
        faces.push_back({t[0], t[1], t[2]});
    return mesh(p, faces);
}

SurfaceMesh bar(int along, int across)
{
    std::map<std::array<int, 3>, int> index;
    std::vector<Vector3> p;
    const auto v = [&](int i, int j, int k) {
        const auto [at, fresh] = index.try_emplace({i, j, k}, static_cast<int>(p.size()));
        if (fresh)
            p.emplace_back(i, j - 0.5 * across, k - 0.5 * across);
        return at->second;
    };
    Polygons faces;
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < across; ++j)
            for (int end : {0, across}) {
                const auto add = [&](int a, int b, int c, int d, bool flip) {
                    faces.push_back(flip ? std::vector{a, d, c, b} : std::vector{a, b, c, d});
                };
                add(v(i, j, end), v(i + 1, j, end), v(i + 1, j + 1, end), v(i, j + 1, end), end == 0);
                add(v(i, end, j), v(i, end, j + 1), v(i + 1, end, j + 1), v(i + 1, end, j), end == 0);
            }
    for (int j = 0; j < across; ++j)
        for (int k = 0; k < across; ++k) {
            faces.push_back({v(0, j, k), v(0, j, k + 1), v(0, j + 1, k + 1), v(0, j + 1, k)});
            faces.push_back({v(along, j, k), v(along, j + 1, k), v(along, j + 1, k + 1), v(along, j, k + 1)});
        }
    return mesh(p, faces);
}

SurfaceMesh messy()
{
    const SurfaceMesh base = hill(8, 8);
    std::vector<Vector3> p = list_of(base.points());
    Polygons faces = faces_of(base);
    const auto add = [&](const Vector3& x) {
        p.push_back(x);
        return static_cast<int>(p.size()) - 1;
    };
    faces.push_back(faces[20]);                                    // doubled
    faces.push_back({10, 11, add(0.5 * (p[10] + p[11]))});         // no area
    faces.push_back({30, 31, add(p[30] + Vector3(0, 1e-9, 1e-9))}); // needle
    faces.push_back({40, 40, 41});                                 // a corner twice
    faces.push_back({50, 51, add(p[50] + Vector3(0, 0, 2))});      // fin
    const int a = add({20, 0, 0}), b = add({21, 0, 0}), c = add({20, 1, 0});
    faces.push_back({a, b, c});                                    // a part of its own
    add({0, 20, 0});                                               // loose
    return mesh(p, faces);
}

SurfaceMesh joined(const SurfaceMesh& first, const SurfaceMesh& second, const Vector3& offset)
{
    Points points(first.vertex_count() + second.vertex_count(), 3);
    points << first.points(), second.points().rowwise() + offset.transpose();
    Polygons faces = faces_of(first);
    for (std::vector<int> face : faces_of(second)) {
        for (int& v : face)
            v += first.vertex_count();
        faces.push_back(std::move(face));
    }
    return over(points, faces);
}

std::vector<Handle> ends(const SurfaceMesh& of, double depth)
{
    const double low = of.points().col(0).minCoeff();
    const double high = of.points().col(0).maxCoeff();
    return {{where(of, [&](const Vector3& p) { return p.x() <= low + depth; }), {}},
            {where(of, [&](const Vector3& p) { return p.x() >= high - depth; }), {}}};
}

Pose still() { return affine(Matrix3::Identity()); }

Pose affine(const Matrix3& linear, const Vector3& move)
{
    Pose pose;
    pose << linear, move;
    return pose;
}

Pose shift(double x, double y, double z) { return affine(Matrix3::Identity(), {x, y, z}); }

Matrix3 rotation(const Vector3& axis, double degrees)
{
    return Eigen::AngleAxisd(degrees * pi / 180, axis.normalized()).toRotationMatrix();
}

Pose turn(const Vector3& axis, double degrees, const Vector3& centre, const Vector3& move)
{
    const Matrix3 R = rotation(axis, degrees);
    return affine(R, centre - R * centre + move);
}

Points transformed(const Points& points, const Pose& pose)
{
    return (points * pose.leftCols<3>().transpose()).rowwise() + pose.col(3).transpose();
}

double distance(const Points& a, const Points& b) { return (a - b).rowwise().norm().maxCoeff(); }

double size(const Points& points)
{
    return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

} // namespace sinew::shapes
