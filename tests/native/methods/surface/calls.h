// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/methods/surface/contract.h"

/// Calls that the tests of every surface method share.
namespace sinew::calls {

using Method = std::shared_ptr<SurfaceMethod>;

inline Method bound(const SurfaceVariant& variant, const SurfaceMesh& mesh,
                    const std::vector<Handle>& handles)
{
    Method method = variant.make(mesh);
    method->set_handles(handles);
    return method;
}

inline Points solve(const SurfaceMethod& method, const Poses& poses, SolveRequest request = {})
{
    Points positions;
    request.poses = poses;
    method.solve(request, positions);
    return positions;
}

/// The end at `along` goes to the end of a circular arc.
inline Poses bend(double degrees, double along = 12, double depth = 2)
{
    const double angle = degrees * shapes::pi / 180, radius = (along - 2 * depth) / angle;
    const Vector3 end(depth + radius * std::sin(angle), radius * (1 - std::cos(angle)), 0);
    const Vector3 from(along - depth, 0, 0);
    return {shapes::still(), shapes::turn({0, 0, 1}, degrees, from, end - from)};
}

inline Poses twist(double degrees) { return {shapes::still(), shapes::turn({1, 0, 0}, degrees)}; }

inline std::vector<Handle> softened(std::vector<Handle> handles, double weight)
{
    handles[1].weights.assign(handles[1].vertices.size(), weight);
    return handles;
}

inline void expect_falling_energy(const SurfaceMethod& method, const Poses& poses)
{
    double before = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 16; ++k) {
        Points q;
        const SolveReport report = method.solve({.poses = poses, .max_iterations = k, .tolerance = 0.0}, q);
        EXPECT_LE(report.iterations, std::max(k, 1));
        EXPECT_LE(report.energy, before * (1 + 1e-12)) << "iteration " << k;
        before = report.energy;
    }
}

/// The bar at rest is as good a start as the method's own, with enough iterations.
inline void expect_starts_meet(const SurfaceMethod& method, double depth, int iterations)
{
    const Points rest = method.rest().points();
    const double along = rest.col(0).maxCoeff();
    for (const Poses& poses : {bend(90, along, depth), twist(135)}) {
        Points own, other;
        SolveRequest request{.poses = poses, .max_iterations = iterations, .tolerance = 1e-15};
        method.solve(request, own);
        request.start.emplace(view(rest));
        request.max_iterations = 2 * iterations;
        method.solve(request, other);
        EXPECT_LT(shapes::distance(own, other), 1e-4 * shapes::size(rest));
    }
}

} // namespace sinew::calls
