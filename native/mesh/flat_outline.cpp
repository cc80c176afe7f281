// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/flat_outline.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <utility>

namespace sinew {

namespace {

using Vector2 = Eigen::Vector2d;

constexpr double flatness = 1e-5; // coordinates have single precision, and objects are turned

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

[[noreturn]] void refuse(const std::string& what, std::vector<int> vertices)
{
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    throw InvalidMesh(what + " at vertices " + list_some(vertices), Error::Element::vertex, vertices);
}

/// The edges along which faces run in one direction only.
std::vector<std::array<int, 2>> border(const SurfaceMesh& mesh)
{
    std::map<std::pair<int, int>, int> balance;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const std::span<const int> face = mesh.face(f);
        for (std::size_t i = 0; i < face.size(); ++i) {
            const int a = face[i], b = face[(i + 1) % face.size()];
            balance[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    }
    std::vector<std::array<int, 2>> found;
    std::vector<int> unlike;
    for (const auto& [edge, count] : balance) {
        const auto [low, high] = edge;
        if (count > 1 || count < -1)
            unlike.insert(unlike.end(), {low, high});
        else if (count == 1)
            found.push_back({low, high});
        else if (count == -1)
            found.push_back({high, low});
    }
    if (!unlike.empty())
        refuse("the faces of the flat cage look to different sides, or overlap,", std::move(unlike));
    return found;
}

/// Names the edges that cross, and the vertices where more than two edges meet.
void check(const FlatOutline& outline, const std::vector<Vector2>& points)
{
    std::map<int, int> degrees;
    for (const auto& [a, b] : outline.edges)
        ++degrees[a], ++degrees[b];
    std::vector<int> crowded;
    for (const auto& [vertex, degree] : degrees)
        if (degree != 2)
            crowded.push_back(vertex);
    if (!crowded.empty())
        refuse("the outline of the flat cage touches itself", std::move(crowded));

    const auto at = [&](int v) -> const Vector2& { return points[static_cast<std::size_t>(v)]; };
    const auto low = [&](const std::array<int, 2>& e) { return std::min(at(e[0]).x(), at(e[1]).x()); };
    std::vector<std::array<int, 2>> sorted = outline.edges;
    std::sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) { return low(a) < low(b); });
    std::vector<int> crossing;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
        const auto [a, b] = sorted[i];
        const double end = std::max(at(a).x(), at(b).x());
        for (std::size_t j = i + 1; j < sorted.size() && low(sorted[j]) <= end; ++j) {
            const auto [c, d] = sorted[j];
            if (a == c || a == d || b == c || b == d)
                continue;
            const Vector2 u = at(b) - at(a), v = at(d) - at(c);
            if (cross(u, at(c) - at(a)) * cross(u, at(d) - at(a)) < 0.0 &&
                cross(v, at(a) - at(c)) * cross(v, at(b) - at(c)) < 0.0)
                crossing.insert(crossing.end(), {a, b, c, d});
        }
    }
    if (!crossing.empty())
        refuse("the outline of the flat cage crosses itself", std::move(crossing));
}

} // namespace

std::optional<FlatOutline> flat_outline(const SurfaceMesh& mesh)
{
    const Eigen::RowVector3d low = mesh.points().colwise().minCoeff(),
                             high = mesh.points().colwise().maxCoeff(), middle = 0.5 * (low + high);
    const double size = (high - low).norm();
    Vector3 area = Vector3::Zero();
    double all = 0.0;
    for (const Triangle& t : mesh.triangles()) {
        const Vector3 part = (mesh.point(t[1]) - mesh.point(t[0])).cross(mesh.point(t[2]) - mesh.point(t[0]));
        area += part;
        all += part.norm();
    }
    // A closed surface has no area vector.
    if (!(area.norm() > 1e-6 * size * size) || !(area.norm() > 1e-3 * all))
        return {};
    FlatOutline outline;
    outline.normal = area.normalized();
    const VectorX heights = (mesh.points().rowwise() - middle) * outline.normal;
    if (heights.maxCoeff() - heights.minCoeff() > flatness * size)
        return {};
    outline.x = outline.normal.unitOrthogonal();
    outline.y = outline.normal.cross(outline.x);
    outline.edges = border(mesh);
    std::vector<Vector2> points;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3 p = mesh.point(v) - middle.transpose();
        points.emplace_back(p.dot(outline.x), p.dot(outline.y));
    }
    check(outline, points);
    return outline;
}

} // namespace sinew
