// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/straight_distance.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr int most_undivided = 8;

} // namespace

StraightDistance::StraightDistance(const SurfaceMesh& mesh,
                                   const std::vector<GeodesicDistance::Source>& sources)
    : axes_(sources.size(), 0)
{
    places_.reserve(sources.size());
    for (const auto& [vertex, distance] : sources)
        places_.push_back({mesh.point(vertex), distance});
    sort(0, static_cast<int>(places_.size()));
}

StraightDistance::StraightDistance(const Points& points, const std::vector<double>& distances)
    : axes_(static_cast<std::size_t>(points.rows()), 0)
{
    places_.reserve(axes_.size());
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        places_.push_back({points.row(i).transpose(), distances.empty() ? 0.0 : distances[i]});
    sort(0, static_cast<int>(places_.size()));
}

void StraightDistance::sort(int begin, int end)
{
    if (end - begin <= most_undivided)
        return;
    Eigen::AlignedBox3d box;
    for (int k = begin; k < end; ++k)
        box.extend(places_[k].point);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(places_.begin() + begin, places_.begin() + middle, places_.begin() + end,
                     [axis](const Place& a, const Place& b) { return a.point[axis] < b.point[axis]; });
    axes_[middle] = static_cast<char>(axis);
    sort(begin, middle);
    sort(middle + 1, end);
}

double StraightDistance::at(const Vector3& x) const
{
    double nearest = std::numeric_limits<double>::infinity();
    search(0, static_cast<int>(places_.size()), x, nearest);
    return nearest;
}

void StraightDistance::search(int begin, int end, const Vector3& x, double& nearest) const
{
    const auto measure = [&](const Place& place) {
        nearest = std::min(nearest, (x - place.point).norm() + place.distance);
    };
    if (end - begin <= most_undivided) {
        std::for_each(places_.begin() + begin, places_.begin() + end, measure);
        return;
    }
    const int middle = begin + (end - begin) / 2, axis = axes_[middle];
    measure(places_[middle]);
    const double beyond = x[axis] - places_[middle].point[axis];
    const bool below = beyond < 0;
    search(below ? begin : middle + 1, below ? middle : end, x, nearest);
    if (std::abs(beyond) < nearest)
        search(below ? middle + 1 : begin, below ? end : middle, x, nearest);
}

} // namespace sinew
