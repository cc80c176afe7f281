// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/attachments/scenes.h"

namespace sinew::scenes {

Piece sheet(int columns, int rows, bool around_a, bool around_b,
            const std::function<Vector3(double, double)>& f)
{
    Piece piece;
    for (int i = 0; i < columns; ++i)
        for (int j = 0; j < rows; ++j)
            piece.points.push_back(f(static_cast<double>(i) / (around_a ? columns : columns - 1),
                                     static_cast<double>(j) / (around_b ? rows : rows - 1)));
    for (int i = 0; i < (around_a ? columns : columns - 1); ++i)
        for (int j = 0; j < (around_b ? rows : rows - 1); ++j) {
            const int next = (i + 1) % columns, side = (j + 1) % rows;
            const int a = i * rows + j, b = next * rows + j, c = next * rows + side, d = i * rows + side;
            piece.triangles.push_back({a, b, c});
            piece.triangles.push_back({a, c, d});
        }
    return piece;
}

Piece plate(int columns, int rows)
{
    return sheet(columns, rows, false, false, [](double a, double b) { return Vector3(10 * a, 10 * b, 0); });
}

Piece tube(double radius, double length, int along, int around)
{
    Piece piece = sheet(along, around, false, true, [&](double a, double b) {
                      const double angle = 2 * shapes::pi * b;
                      return Vector3(length * a, radius * std::cos(angle), radius * std::sin(angle));
                  }).inside_out();
    const int n = static_cast<int>(piece.points.size());
    piece.points.emplace_back(0, 0, 0);
    piece.points.emplace_back(length, 0, 0);
    for (int j = 0; j < around; ++j) {
        const int k = (j + 1) % around, last = (along - 1) * around;
        piece.triangles.push_back({n, j, k});
        piece.triangles.push_back({n + 1, last + k, last + j});
    }
    return piece;
}

Piece ring(double radius, double thick, double x)
{
    return sheet(96, 12, true, true, [&](double a, double b) {
        const double u = 2 * shapes::pi * a, v = 2 * shapes::pi * b, r = radius + thick * std::cos(v);
        return Vector3(x + thick * std::sin(v), r * std::cos(u), r * std::sin(u));
    });
}

Piece block(const Vector3& size, const Vector3& centre, const std::array<int, 3>& cells,
            const Matrix3& turned)
{
    Piece piece;
    std::map<std::array<int, 3>, int> index;
    const auto at = [&](std::array<int, 3> i) {
        const auto [found, fresh] = index.try_emplace(i, static_cast<int>(piece.points.size()));
        if (fresh) {
            Vector3 p;
            for (int c = 0; c < 3; ++c)
                p[c] = size[c] * (static_cast<double>(i[c]) / cells[c] - 0.5);
            piece.points.emplace_back(turned * p + centre);
        }
        return found->second;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (int far : {0, 1}) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (int i = 0; i < cells[u]; ++i)
                for (int j = 0; j < cells[v]; ++j) {
                    const auto corner = [&](int di, int dj) {
                        std::array<int, 3> k{};
                        k[axis] = far * cells[axis];
                        k[u] = i + di;
                        k[v] = j + dj;
                        return at(k);
                    };
                    const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
                    if (far) {
                        piece.triangles.push_back({a, b, c});
                        piece.triangles.push_back({a, c, d});
                    } else {
                        piece.triangles.push_back({a, c, b});
                        piece.triangles.push_back({a, d, c});
                    }
                }
        }
    return piece;
}

Scene tube_and_balls()
{
    return {tube(1, 10), ball(.6, {5, 0, 0}), ball(.3, {3, 0, .6}), ball(.1, {5, 0, -.95}),
            block({.3, .3, .1}, {6, 0, 1.04}, {6, 6, 6})};
}

Scene belts()
{
    const Piece helix = sheet(160, 8, false, true, [](double a, double b) {
        const double r = 1.1 + .06 * std::cos(2 * shapes::pi * b);
        return Vector3(2 + 6 * a, r * std::cos(9 * a), r * std::sin(9 * a));
    });
    return {tube(1, 10), ring(1.12, .1, 5), ring(1.08, .06, 3), block({7, .4, .08}, {5, 0, 1.08}, {70, 4, 1}),
            helix};
}

/// A plate of scales.
Scene scales()
{
    Scene scene{plate(81, 81)};
    for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 12; ++j)
            scene.add(block({.9, .7, .06}, {.6 + .8 * i, .6 + .8 * j, .08}, {3, 3, 1},
                            shapes::rotation({0, 1, 0}, -7)));
    return scene;
}

Scene head()
{
    Piece skin = ball(1, {0, 0, 0}, 96, 64);
    for (double side : {-.38, .38})
        for (Vector3& p : skin.points) {
            const double t = std::clamp(1 - (p - Vector3(side, -.87, .3)).norm() / .32, 0.0, 1.0);
            p.y() += .28 * t * t * (3 - 2 * t);
        }
    Scene scene{skin};
    for (double side : {-.38, .38}) {
        scene.add(ball(.2, {side, -.80, .3}));
        scene.add(ball(.09, {side, -.985, .3}, 16, 8, {1, .25, 1}));
        scene.add(ball(.03, {side, -1.01, .3}, 12, 6, {1, .25, 1}));
    }
    return scene;
}

Scene limbs()
{
    const Piece legs = sheet(112, 24, false, true, [](double a, double b) {
        const double s = 14 * a, t = std::clamp((s - 5) / 4, 0.0, 1.0) * shapes::pi;
        Vector3 centre(-.8 * std::cos(t), 0, .8 * std::sin(t)), out(std::cos(t), 0, -std::sin(t));
        if (s < 5)
            centre.z() = s - 5;
        if (s > 9)
            centre.z() = 9 - s;
        const double angle = 2 * shapes::pi * b;
        return Vector3(centre + .6 * (std::cos(angle) * out + std::sin(angle) * Vector3(0, 1, 0)));
    });
    return {legs, ball(.12, {0, 0, -3.5}), block({.3, .1, .3}, {0, -.5, -3}, {6, 6, 6}),
            block({1.6, .05, 3}, {0, -.7, -1.2}, {16, 1, 30})};
}

Vector3 stride(const Vector3& p)
{
    const double angle = std::copysign(50 * std::clamp(-p.z(), 0.0, 1.0), p.x());
    return shapes::rotation({1, 0, 0}, angle) * p;
}

Vector3 rolled(const Vector3& p, double radius)
{
    const double angle = (p.x() - 5) / radius;
    return {5 + (radius - p.z()) * std::sin(angle), p.y(), radius - (radius - p.z()) * std::cos(angle)};
}

Vector3 twisted(const Vector3& p) { return shapes::rotation({1, 0, 0}, .3 * p.x() * 180 / shapes::pi) * p; }

std::map<std::string, Scene> all()
{
    return {{"tube", tube_and_balls()},
            {"belts", belts()},
            {"scales", scales()},
            {"head", head()},
            {"limbs", limbs()},
            {"one triangle",
             {Piece{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {Triangle{0, 1, 2}}}, ball(.1, {.3, .3, .2}, 8, 6)}}};
}

} // namespace sinew::scenes
