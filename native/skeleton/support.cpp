// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/support.h"

#include "native/core/errors.h"
#include "native/core/finite.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>

namespace sinew {

namespace {

using Place = Eigen::Vector2d;

double turn(const Place& a, const Place& b, const Place& c)
{
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// A. M. Andrew. "Another efficient algorithm for convex hulls in two dimensions." 1979. Counterclockwise.
std::vector<Place> convex_hull(std::vector<Place> places)
{
    std::ranges::sort(places, [](const Place& a, const Place& b) {
        return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    });
    std::vector<Place> hull;
    for (int half = 0; half < 2; ++half) {
        const std::size_t begin = hull.size();
        for (const Place& place : places) {
            while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), place) <= 0)
                hull.pop_back();
            hull.push_back(place);
        }
        hull.pop_back(); // the first place of the other half
        std::ranges::reverse(places);
    }
    return hull;
}

} // namespace

Support::Support(const Points& points, const Vector3& up)
{
    if (!all_finite(points) || !all_finite(up) || !(up.norm() > 0))
        throw InvalidConstraint("balance: a point of the support is not finite, or there is no direction up");
    const Vector3 normal = up.normalized(), right = normal.unitOrthogonal(), ahead = normal.cross(right);
    std::vector<Place> places;
    for (Eigen::Index k = 0; k < points.rows(); ++k)
        places.emplace_back(points.row(k).dot(right), points.row(k).dot(ahead));
    const std::vector<Place> hull = places.size() < 3 ? std::vector<Place>() : convex_hull(places);
    double area = 0.0, reach = 0.0;
    for (std::size_t k = 1; k + 1 < hull.size(); ++k)
        area += turn(hull[0], hull[k], hull[k + 1]) / 2;
    for (const Place& place : hull)
        reach = std::max(reach, (place - hull[0]).norm());
    if (!(area > 1e-9 * reach * reach))
        throw InvalidConstraint("balance: the support has no area; give at least three points that are not "
                                "on a line");
    for (std::size_t k = 0; k < hull.size(); ++k) {
        const Place &a = hull[k], side = hull[(k + 1) % hull.size()] - a;
        const Vector3 out = (side.y() * right - side.x() * ahead).normalized();
        normals_.push_back(out);
        offsets_.push_back(out.dot(a.x() * right + a.y() * ahead));
    }
}

} // namespace sinew
