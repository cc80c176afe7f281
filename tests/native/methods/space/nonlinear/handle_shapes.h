// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/nonlinear/handles/handle_method.h"
#include "tests/native/shapes.h"

#include <utility>
#include <vector>

/// Handles and warps that the tests of nonlinear space methods share.
namespace sinew::shapes {

/// The points of regions, handle after handle.
inline HandlePoints held_by(const SurfaceMesh& of, const std::vector<std::vector<int>>& regions)
{
    std::vector<int> vertices, counts;
    for (const std::vector<int>& region : regions) {
        counts.push_back(static_cast<int>(region.size()));
        vertices.insert(vertices.end(), region.begin(), region.end());
    }
    const Points points = of.points()(vertices, Eigen::all);
    return HandlePoints(view(points), std::move(counts));
}

/// Both ends along x.
inline HandlePoints held_ends(const SurfaceMesh& of, double depth)
{
    std::vector<std::vector<int>> regions;
    for (const Handle& handle : ends(of, depth))
        regions.push_back(handle.vertices);
    return held_by(of, regions);
}

inline Points warped(const HandleMethod& method, const Poses& poses,
                     const std::optional<PointsView>& incoming = {}, const std::vector<bool>& from_rest = {})
{
    Points out(method.points().rows(), 3);
    method.warp_poses(poses, incoming, out.data(), out.rows(), from_rest);
    return out;
}

/// Poses of the ends of a bar of length 24 along x.
inline Poses bent(double degrees) { return {still(), turn({0, 1, 0}, degrees, {12, 0, 0}, {-3, 0, 0})}; }
inline Poses twisted(double degrees) { return {still(), turn({1, 0, 0}, degrees)}; }

/// Largest distance, as a share of the size.
inline double apart(const Points& a, const Points& b) { return distance(a, b) / size(b); }

} // namespace sinew::shapes
