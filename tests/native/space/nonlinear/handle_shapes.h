// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/nonlinear/handles/handle_method.h"
#include "tests/native/shapes.h"

#include <cstddef>
#include <vector>

/// Handles and warps that the tests of nonlinear space methods share.
namespace sinew::shapes {

/// The points of regions, handle after handle.
inline HeldPoints held_by(const SurfaceMesh& of, const std::vector<std::vector<int>>& regions)
{
    HeldPoints held;
    Eigen::Index count = 0;
    for (const std::vector<int>& region : regions)
        count += static_cast<Eigen::Index>(region.size());
    held.points.resize(count, 3);
    Eigen::Index row = 0;
    for (const std::vector<int>& region : regions) {
        held.counts.push_back(static_cast<int>(region.size()));
        for (int v : region)
            held.points.row(row++) = of.points().row(v);
    }
    return held;
}

/// Both ends along x.
inline HeldPoints held_ends(const SurfaceMesh& of, double depth)
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

/// Largest distance, as a share of the size.
inline double apart(const Points& a, const Points& b) { return distance(a, b) / size(b); }

} // namespace sinew::shapes
