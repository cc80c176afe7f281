// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/bone_regions.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/trees/triangle_tree.h"
#include "native/operators/geodesic_distance.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// A vertex starts as one of a bone up to this many times the bone's distance from the surface.
constexpr double reach = 1.5;
constexpr double wound = 0.3;  ///< the least winding number inside of a surface with holes
constexpr double facing = 0.5; ///< the cosine of how far a bone may be aside of the normal

/// Where a point is beside a bone.
struct Beside
{
    double along; ///< 0 at the head and 1 at the tail, beyond them less and more
    Vector3 away; ///< from the closest point of the bone
    double distance;
};

Beside beside(const Skeleton& skeleton, int bone, const Vector3& point)
{
    const Vector3 head = skeleton.head(bone), bone_vector = skeleton.tail(bone) - head;
    const double along = (point - head).dot(bone_vector) / bone_vector.squaredNorm();
    const Vector3 away = point - head - std::clamp(along, 0.0, 1.0) * bone_vector;
    return {along, away, away.norm()};
}

std::array<Vector3, 3> corners(const SurfaceMesh& mesh, const Triangle& triangle)
{
    return {mesh.point(triangle[0]), mesh.point(triangle[1]), mesh.point(triangle[2])};
}

/// (n, 3) unit normals of the vertices; zero where there is no surface. They point outward also where the
/// faces of a closed mesh look inward.
Points outward_normals(const SurfaceMesh& mesh)
{
    Points normals = Points::Zero(mesh.vertex_count(), 3);
    const Vector3 middle = mesh.points().colwise().mean().transpose();
    double volume = 0.0;
    for (const Triangle& triangle : mesh.triangles()) {
        const std::array<Vector3, 3> at = corners(mesh, triangle);
        const Vector3 area = (at[1] - at[0]).cross(at[2] - at[0]);
        volume += area.dot(at[0] - middle);
        for (int k = 0; k < 3; ++k) { // by angles, so that it does not matter how faces were cut
            const Vector3 one = at[(k + 1) % 3] - at[k], other = at[(k + 2) % 3] - at[k];
            const double angle = std::atan2(one.cross(other).norm(), one.dot(other));
            normals.row(triangle[k]) += angle * area.normalized().transpose();
        }
    }
    for (auto normal : normals.rowwise())
        normal = (volume < 0 ? -1.0 : 1.0) * normal.normalized().eval();
    return normals;
}

/// Whether the surface winds around a part of each bone. It may have holes.
std::vector<char> bones_inside(const SurfaceMesh& mesh, const Skeleton& skeleton)
{
    std::vector<Vector3> points(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v)
        points[v] = mesh.point(v);
    std::vector<char> inside(skeleton.bone_count());
    parallel_for(skeleton.bone_count(), [&](int b) {
        const Vector3 head = skeleton.head(b), along = skeleton.tail(b) - head;
        for (double share : {0.5, 0.25, 0.75})
            inside[b] =
                inside[b] || std::abs(winding_number(points, mesh.triangles(), head + share * along)) > wound;
    });
    return inside;
}

} // namespace

std::vector<std::vector<int>> bone_regions(const SurfaceMesh& mesh, const Skeleton& skeleton, double margin)
{
    if (!(margin >= 0 && margin < 0.5))
        throw InvalidOption("margin: give a share of at least 0 and less than 0.5");
    const int n = mesh.vertex_count(), bones = skeleton.bone_count();
    const std::vector<char> inside = bones_inside(mesh, skeleton);
    const Points normals = outward_normals(mesh);
    std::vector<int> nearest(n, -1);
    parallel_for(n, [&](int v) {
        double least = infinite;
        for (int b = 0; b < bones; ++b) {
            const Beside at = beside(skeleton, b, mesh.point(v));
            const double outward = normals.row(v).dot(at.away);
            if (inside[b] && outward > facing * at.distance && at.distance * at.distance < least * outward) {
                least = at.distance * at.distance / outward; // the diameter of the ball
                nearest[v] = b;
            }
        }
    });
    // How far each bone is from the surface around it.
    std::vector<std::vector<double>> around(bones);
    for (int v = 0; v < n; ++v)
        if (nearest[v] >= 0)
            if (const Beside at = beside(skeleton, nearest[v], mesh.point(v)); at.along > 0 && at.along < 1)
                around[nearest[v]].push_back(at.distance);
    std::vector<std::vector<GeodesicDistance::Source>> sources(bones);
    std::vector<double> radius(bones, 0.0);
    for (int b = 0; b < bones; ++b)
        if (!around[b].empty()) {
            const auto middle = around[b].begin() + static_cast<std::ptrdiff_t>(around[b].size() / 4);
            std::ranges::nth_element(around[b], middle);
            radius[b] = *middle;
        }
    for (int v = 0; v < n; ++v) {
        if (nearest[v] < 0)
            continue;
        const Beside at = beside(skeleton, nearest[v], mesh.point(v));
        if (at.along >= 0 && at.along <= 1 && at.distance <= reach * radius[nearest[v]])
            sources[nearest[v]].push_back({v});
    }
    std::vector<int> owner(n, -1);
    std::vector<double> way(n, infinite);
    const GeodesicDistance along_surface(mesh);
    for (int b = 0; b < bones; ++b) {
        if (sources[b].empty())
            continue;
        const std::vector<double> ways = along_surface.from(sources[b]);
        for (int v = 0; v < n; ++v)
            if (ways[v] < way[v]) {
                way[v] = ways[v];
                owner[v] = b;
            }
    }
    // A joint is where bones meet: at the head of a bone with a parent, and at a tail near which a child
    // begins.
    std::vector<bool> joint_at_tail(bones, false);
    for (int b = 0; b < bones; ++b)
        if (const int parent = skeleton.parent(b); parent >= 0) {
            const double length = (skeleton.tail(parent) - skeleton.head(parent)).norm();
            if ((skeleton.head(b) - skeleton.tail(parent)).norm() <= 0.5 * length)
                joint_at_tail[parent] = true;
        }
    std::vector<std::vector<int>> regions(bones);
    for (int v = 0; v < n; ++v) {
        const int b = owner[v];
        if (b < 0)
            continue;
        const double along = beside(skeleton, b, mesh.point(v)).along;
        const bool at_head = skeleton.parent(b) >= 0 && along < margin,
                   at_tail = joint_at_tail[b] && along > 1 - margin;
        if (!at_head && !at_tail)
            regions[b].push_back(v);
    }
    return regions;
}

} // namespace sinew
