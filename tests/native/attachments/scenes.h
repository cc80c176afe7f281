// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/attachments.h"
#include "tests/native/shapes.h"

#include <functional>
#include <string>

/// Bodies with loose parts, and ways to deform the bodies.
namespace sinew::scenes {

using Places = std::vector<Vector3>;

/// One closed or open surface.
struct Piece
{
    Places points;
    std::vector<Triangle> triangles;

    Piece inside_out() const
    {
        Piece piece = *this;
        for (Triangle& t : piece.triangles)
            std::swap(t[1], t[2]);
        return piece;
    }
};

/// A grid of columns x rows over f(a, b) with a and b in [0, 1], closed around where that is said.
Piece sheet(int columns, int rows, bool around_a, bool around_b,
            const std::function<Vector3(double, double)>& f);

Piece plate(int columns, int rows);

/// Along x, outward, closed by discs.
Piece tube(double radius, double length, int along = 160, int around = 40);

inline Piece ball(double radius, const Vector3& centre, int around = 24, int rings = 16,
                  const Vector3& scale = {1, 1, 1})
{
    Piece piece;
    piece.points.emplace_back(0, 0, 1);
    for (int i = 1; i < rings; ++i)
        for (int j = 0; j < around; ++j) {
            const double t = shapes::pi * i / rings, p = 2 * shapes::pi * j / around;
            piece.points.emplace_back(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t));
        }
    piece.points.emplace_back(0, 0, -1);
    const int last = static_cast<int>(piece.points.size()) - 1;
    const auto at = [&](int i, int j) { return 1 + (i - 1) * around + j % around; };
    for (int j = 0; j < around; ++j) {
        piece.triangles.push_back({0, at(1, j), at(1, j + 1)});
        for (int i = 1; i + 1 < rings; ++i) {
            piece.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            piece.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
        piece.triangles.push_back({at(rings - 1, j), last, at(rings - 1, j + 1)});
    }
    for (Vector3& point : piece.points)
        point = radius * point.cwiseProduct(scale) + centre;
    return piece;
}

/// Around the x axis.
Piece ring(double radius, double thick, double x);

Piece block(const Vector3& size, const Vector3& centre, const std::array<int, 3>& cells,
            const Matrix3& turned = Matrix3::Identity());

/// A mesh whose first piece is driven.
struct Scene
{
    std::vector<Vector3> points;
    shapes::Polygons faces;
    std::vector<int> firsts; ///< the first vertex of each piece, and the number of all

    Scene(std::initializer_list<Piece> pieces)
    {
        for (const Piece& piece : pieces)
            add(piece);
    }

    void add(const Piece& piece)
    {
        if (firsts.empty())
            firsts.push_back(0);
        const int first = firsts.back();
        points.insert(points.end(), piece.points.begin(), piece.points.end());
        for (const auto& [a, b, c] : piece.triangles)
            faces.push_back({first + a, first + b, first + c});
        firsts.push_back(static_cast<int>(points.size()));
    }

    SurfaceMesh mesh() const { return shapes::mesh(points, faces); }
    int body() const { return firsts[1]; }
    Points piece(const Points& of, int number) const
    {
        return of.middleRows(firsts[number], firsts[number + 1] - firsts[number]);
    }
};

/// A scene whose loose parts follow the first one.
struct Carried
{
    Scene scene;
    SurfaceMesh mesh;
    Components parts;
    Attachments attachments;

    explicit Carried(const Scene& from, double stiffness = 0.0)
        : scene(from), mesh(from.mesh()), parts(connected_components(mesh)),
          attachments(mesh, parts, driven(), {.follow = true, .stiffness = {stiffness}})
    {
    }

    std::vector<bool> driven() const
    {
        std::vector<bool> flags(parts.count, false);
        flags[0] = true;
        return flags;
    }

    /// Where the parts go if the body goes to its rows of `all`, whatever the other rows of it say.
    Points moved(const Points& all, const std::optional<PointsView>& incoming = {}) const
    {
        Points positions = all;
        positions.bottomRows(all.rows() - scene.body()).setConstant(1000);
        attachments.move(incoming, positions);
        return positions;
    }
    Points moved(const std::function<Vector3(const Vector3&)>& by) const { return moved(deformed(by)); }
    Points deformed(const std::function<Vector3(const Vector3&)>& by) const
    {
        Points all(mesh.vertex_count(), 3);
        for (int v = 0; v < mesh.vertex_count(); ++v)
            all.row(v) = by(mesh.point(v)).transpose();
        return all;
    }
    Points rest(int part) const { return scene.piece(mesh.points(), part); }
    const Ride& ride(int part) const { return attachments.rides().at(part - 1); }
};

Scene tube_and_balls();

Scene belts();

/// A head with two sockets; in each an eye with an iris and a pupil, which overlap.
Scene head();

/// Two limbs close together that a torso joins; a ball and a button midway, and a cloth over both.
Scene limbs();

/// The limbs swing apart, one to the front and one to the back.
Vector3 stride(const Vector3& p);

/// Rolls the plane z = 0 onto a cylinder of this radius about the line x = 5, and what is above with it.
Vector3 rolled(const Vector3& p, double radius);

Vector3 twisted(const Vector3& p);

std::map<std::string, Scene> all();

} // namespace sinew::scenes
