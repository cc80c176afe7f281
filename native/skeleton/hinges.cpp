// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/hinges.h"

#include <Eigen/Geometry>

#include <limits>

namespace sinew {

namespace {

constexpr double straight = 1e-3; ///< radians: less of a bend says nothing about its plane
constexpr int none = -1, several = -2;

/// (bones) the bone by which each one goes on: `none`, or `several`.
std::vector<int> next_bones(const Skeleton& skeleton)
{
    const int count = skeleton.bone_count();
    std::vector<int> next(count, none);
    std::vector<bool> carries(count, false);
    for (int b = 0; b < count; ++b)
        if (skeleton.parent(b) >= 0)
            carries[skeleton.parent(b)] = true;
    for (const bool leaves : {false, true}) {
        std::vector<int> found(count, none);
        for (int b = 0; b < count; ++b)
            if (const int parent = skeleton.parent(b); parent >= 0 && carries[b] != leaves)
                found[parent] = found[parent] == none ? b : several;
        for (int b = 0; b < count; ++b)
            if (next[b] == none)
                next[b] = found[b];
    }
    return next;
}

} // namespace

std::vector<Hinge> hinges(const Skeleton& skeleton)
{
    const std::vector<int> next = next_bones(skeleton);
    std::vector<Hinge> all(next.size());
    for (int b = 0; b < skeleton.bone_count(); ++b) {
        const int parent = skeleton.parent(b);
        const Joint& joint = skeleton.joint(b);
        if (parent < 0 || next[parent] != b || joint.kind != Joint::Kind::ball ||
            joint.most < std::numeric_limits<double>::infinity())
            continue;
        const Vector3 before = (skeleton.tail(parent) - skeleton.head(parent)).normalized(),
                      along = (skeleton.tail(b) - skeleton.head(b)).normalized(), bend = before.cross(along);
        if (bend.norm() < straight)
            continue;
        Matrix3& axes = all[b].emplace();
        axes.col(0) = skeleton.axes(b).transpose() * bend.normalized();
        axes.col(1) = skeleton.axes(b).transpose() * along;
        axes.col(2) = axes.col(0).cross(axes.col(1));
    }
    return all;
}

} // namespace sinew
