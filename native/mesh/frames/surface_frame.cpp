// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/surface_frame.h"

#include "native/core/dense.h"
#include "native/mesh/components.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr double per_spread = 4.0;       ///< the size by the root mean square of the distance
constexpr double equal_spread = 0.02;     ///< of the largest: what differs by less is open
constexpr double least_skewness = 1e-3;  ///< below it, a direction has no side that reaches farther
constexpr double rounding = 1e-6;        ///< of the size: what differs by less is equal
constexpr double steps = 1 << 16;        ///< of the size
constexpr double between_regular = 0.37; ///< of a step: where steps end, so that no regular shape is there

/// Points with the weights of the area around them; the moments of three points per triangle are exact.
struct Masses
{
    std::vector<Vector3> points;
    std::vector<double> weights;

    void reserve(std::size_t count)
    {
        points.reserve(count);
        weights.reserve(count);
    }
    void add(const Vector3& point, double weight)
    {
        points.push_back(point);
        weights.push_back(weight);
    }
    bool weigh() const
    {
        return std::ranges::any_of(weights, [](double w) { return w > 0.0; });
    }
};

/// The masses of the triangles of each part of a mesh, or of their edges. The vertices come first, without
/// any: what a symmetry leaves open they decide, in whatever order a face has its corners.
std::vector<Masses> masses_of(const SurfaceMesh& mesh, bool of_area, const std::vector<int>& labels,
                              int count)
{
    std::vector<Masses> masses(static_cast<std::size_t>(count));
    if (count == 1)
        masses.front().reserve(labels.size() + 3 * mesh.triangles().size());
    std::vector<char> has_face(labels.size(), 0);
    for (const Triangle& t : mesh.triangles())
        for (const int v : t)
            has_face[v] = 1;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (has_face[v])
            masses[labels[v]].add(mesh.point(v), 0.0);
    for (const Triangle& t : mesh.triangles()) {
        const Vector3 p[3] = {mesh.point(t[0]), mesh.point(t[1]), mesh.point(t[2])};
        const double area = (p[1] - p[0]).cross(p[2] - p[0]).norm() / 6.0;
        for (int k = 0; k < 3; ++k)
            masses[labels[t[0]]].add(0.5 * (p[k] + p[(k + 1) % 3]),
                                     of_area ? area : (p[k] - p[(k + 1) % 3]).norm());
    }
    return masses;
}

struct Moments
{
    Vector3 centre;
    double spread; ///< the root mean square of the distance from the centre
    double size() const { return spread > 0.0 ? per_spread * spread : 1.0; }
};

Moments moments_of(const std::vector<Vector3>& points, const std::vector<double>& weights)
{
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const Vector3& origin = points.front(); // so that nothing is lost far from the origin
    Vector3 centre = Vector3::Zero();
    for (std::size_t k = 0; k < points.size(); ++k)
        centre += weights[k] / sum * (points[k] - origin);
    centre += origin;
    double farthest = 0.0;
    for (const Vector3& p : points)
        farthest = std::max(farthest, (p - centre).cwiseAbs().maxCoeff());
    double square = 0.0;
    for (std::size_t k = 0; k < points.size() && farthest > 0.0; ++k)
        square += weights[k] / sum * ((points[k] - centre) / farthest).squaredNorm();
    return {centre, farthest * std::sqrt(square)};
}

/// Along a side of a square or a cube: from the first of the arms that reach farthest in a space to the
/// nearest of those that reach as far, or along itself if there is none; zero if nothing reaches anywhere.
Vector3 side_in(const Matrix3& space, const std::vector<Vector3>& arms)
{
    Vector3 first = Vector3::Zero();
    for (const Vector3& arm : arms)
        if (const Vector3 part = space * arm; part.norm() > (1 + rounding) * first.norm() + rounding)
            first = part;
    Vector3 side = first;
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3& arm : arms) {
        const Vector3 part = space * arm;
        const double apart = (part - first).norm();
        if (part.norm() > (1 - 2 * rounding) * first.norm() - rounding && apart > 4 * rounding &&
            apart < (1 - rounding) * least) {
            least = apart;
            side = part - first;
        }
    }
    return side;
}

/// Directions of most, second and least spread, as columns. Among directions of equal spread the arms that
/// reach farthest in them decide, so that the directions go with a shape that is turned.
Matrix3 directions_of(const Matrix3& spread, const std::vector<Vector3>& arms)
{
    const auto [values, vectors] = eigenvectors(spread); // rising
    const auto is_same = [&, most = equal_spread * values[2]](int i, int j) {
        for (int k = std::min(i, j); k < std::max(i, j); ++k)
            if (values[k + 1] - values[k] > most)
                return false;
        return true;
    };
    Matrix3 axes = Matrix3::Zero();
    for (int k = 2; k >= 0; --k) {
        Matrix3 space = -axes * axes.transpose();
        for (int j = 0; j < 3; ++j)
            if (j > k || is_same(j, k)) // those above are taken away again
                space += vectors.col(j) * vectors.col(j).transpose();
        Eigen::Index clearest = 0;
        space.colwise().norm().maxCoeff(&clearest);
        const Vector3 along = space.trace() > 1.5 ? side_in(space, arms) : Vector3::Zero();
        axes.col(2 - k) = (along.norm() > rounding ? along : Vector3(space.col(clearest))).normalized();
    }
    return axes;
}

} // namespace

SurfaceFrame frame_of_points(const std::vector<Vector3>& points, const std::vector<double>& weights)
{
    SurfaceFrame frame;
    const Moments moments = moments_of(points, weights);
    frame.centre = moments.centre;
    frame.size = moments.size();
    if (!(moments.spread > 0.0))
        return frame;
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    Matrix3 spread = Matrix3::Zero();
    std::vector<Vector3> arms;
    arms.reserve(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        arms.emplace_back((points[k] - frame.centre) / frame.size);
        spread += weights[k] / sum * arms[k] * arms[k].transpose();
    }
    frame.axes = directions_of(spread, arms);
    Vector3 skewness = Vector3::Zero();
    for (std::size_t k = 0; k < arms.size(); ++k)
        skewness += weights[k] / sum * (frame.axes.transpose() * arms[k]).array().cube().matrix();
    const double least = least_skewness * std::pow(spread.trace(), 1.5);
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(skewness[axis]) < least) { // rounding decides nothing
            const auto is_beside = [&](const Vector3& arm) {
                return std::abs(arm.dot(frame.axes.col(axis))) > rounding;
            };
            const auto first = std::ranges::find_if(arms, is_beside);
            skewness[axis] = first == arms.end() ? 0.0 : std::copysign(0.0, first->dot(frame.axes.col(axis)));
        }
        if (std::signbit(skewness[axis]))
            frame.axes.col(axis) *= -1;
    }
    if (frame.axes.determinant() < 0) {
        skewness.cwiseAbs().minCoeff(&frame.mirrored);
        frame.axes.col(frame.mirrored) *= -1;
    }
    return frame;
}

SurfaceFrame surface_frame(const SurfaceMesh& mesh)
{
    const std::vector<int> one_part(static_cast<std::size_t>(mesh.vertex_count()), 0);
    for (const bool of_area : {true, false})
        if (const Masses masses = masses_of(mesh, of_area, one_part, 1).front(); masses.weigh())
            return frame_of_points(masses.points, masses.weights);
    Masses all;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        all.add(mesh.point(v), 1.0);
    return frame_of_points(all.points, all.weights);
}

namespace {

/// The masses of the parts: of their edges where a part has no area, and none where it is in one place.
std::vector<Masses> masses_of_parts(const SurfaceMesh& mesh, const Components& parts)
{
    std::vector<Masses> masses = masses_of(mesh, true, parts.labels, parts.count);
    if (!std::ranges::all_of(masses, &Masses::weigh)) {
        std::vector<Masses> edges = masses_of(mesh, false, parts.labels, parts.count);
        for (int part = 0; part < parts.count; ++part)
            if (!masses[part].weigh())
                masses[part] = edges[part].weigh() ? std::move(edges[part]) : Masses();
    }
    return masses;
}

/// Where a point is in a frame: the distance from the centre, and the coordinates, in steps of the size.
std::array<std::int64_t, 4> place_in(const SurfaceFrame& frame, const Vector3& point)
{
    const double unit = frame.size > 0.0 ? frame.size : 1.0;
    const auto step = [&](double length) {
        return static_cast<std::int64_t>(
            std::floor(std::clamp(length / unit, -1e9, 1e9) * steps + between_regular));
    };
    Vector3 p = frame.in(point);
    if (frame.mirrored >= 0)
        p[frame.mirrored] *= -1;
    return {step(p.norm()), step(p.x()), step(p.y()), step(p.z())};
}

/// The indices of places, by these and then by themselves.
std::vector<int> sorted(const std::vector<std::array<std::int64_t, 4>>& places)
{
    std::vector<int> order(places.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int i) { return places[i]; });
    return order;
}

} // namespace

std::vector<double> part_sizes(const SurfaceMesh& mesh)
{
    const Components parts = connected_components(mesh);
    std::vector<double> part_size;
    for (const Masses& masses : masses_of_parts(mesh, parts))
        part_size.push_back(masses.points.empty() ? 0.0 : moments_of(masses.points, masses.weights).size());
    const double largest = std::ranges::max(part_size);
    std::vector<double> sizes;
    for (const int part : parts.labels)
        sizes.push_back(part_size[part] > 0.0 ? part_size[part] : largest > 0.0 ? largest : 1.0);
    return sizes;
}

std::vector<int> order_by_place(PointsView points, const SurfaceFrame& frame)
{
    std::vector<std::array<std::int64_t, 4>> places;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        places.push_back(place_in(frame, points.row(i).transpose()));
    return sorted(places);
}

std::vector<int> order_by_place(const SurfaceMesh& mesh)
{
    const Components parts = connected_components(mesh);
    std::vector<SurfaceFrame> frames;
    for (const Masses& masses : masses_of_parts(mesh, parts))
        frames.push_back(masses.points.empty() ? SurfaceFrame{.size = 0.0}
                                               : frame_of_points(masses.points, masses.weights));
    std::vector<std::array<std::int64_t, 4>> places;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        places.push_back(place_in(frames[parts.labels[v]], mesh.point(v)));
    return sorted(places);
}

} // namespace sinew
