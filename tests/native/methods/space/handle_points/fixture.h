// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/handle_points/handle_points.h"
#include "native/methods/space/method.h"
#include "tests/native/shapes.h"

#include <cstdint>
#include <vector>

/// Handles, poses and points that the tests of methods around handle points share.
namespace sinew::handles {

inline Points random_points(int count, double reach, std::uint64_t seed)
{
    return shapes::Random(seed).points(count, reach);
}

/// Two regions of a bar, and a point of its own.
inline HandlePoints regions(int each)
{
    Points points = random_points(2 * each + 1, 1.0, 7);
    points.topRows(each).col(0).array() -= 3.0;
    points.middleRows(each, each).col(0).array() += 3.0;
    points.row(2 * each) << 0, 2, 0;
    return HandlePoints(view(points), {each, each, 1});
}

/// Of these regions.
inline const std::vector<Pose> three_poses{shapes::still(), shapes::turn({1, 2, 3}, 70, {3, 0, 0}, {0, 1, 0}),
                                           shapes::shift(0, 0.5, 0.2)};

/// The control where the poses take it.
inline Points posed(const HandlePoints& handles, const std::vector<Pose>& poses)
{
    Points control = handles.control();
    for (int h = 0; h < handles.handle_count(); ++h)
        for (int r = handles.column(h); r < handles.column(h + 1); ++r)
            control.row(r) = apply(poses[h], Vector3(control.row(r).transpose())).transpose();
    return control;
}

/// The handle points where the poses take them.
inline Points moved(const HandlePoints& handles, const std::vector<Pose>& poses)
{
    Points points = handles.points();
    for (int i = 0; i < handles.point_count(); ++i)
        points.row(i) = apply(poses[handles.handle_of(i)], Vector3(points.row(i).transpose())).transpose();
    return points;
}

inline Points warped(SpaceMethod& method, const Points& points, const Points& control)
{
    method.bind(view(points));
    Points out(points.rows(), 3);
    method.warp(view(control), {}, out.data());
    return out;
}

} // namespace sinew::handles
