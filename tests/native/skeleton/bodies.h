// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/skeleton/skeleton.h"
#include "tests/native/shapes.h"

#include <vector>

/// Skeletons that the tests share.
namespace sinew::bodies {

/// Bones of length 1 along z, one on the other.
inline Skeleton chain(int count, const std::vector<Joint>& joints = {})
{
    Points heads = Points::Zero(count, 3), tails = Points::Zero(count, 3);
    std::vector<int> parents;
    for (int b = 0; b < count; ++b) {
        heads(b, 2) = b;
        tails(b, 2) = b + 1;
        parents.push_back(b - 1);
    }
    return {heads, tails, parents, {}, joints};
}

/// The same, each joint a little beside the line, so that those in between have hinges in several planes.
inline Skeleton zigzag(int count, const std::vector<Joint>& joints = {})
{
    const Vector3 beside[] = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
    Points heads(count, 3), tails(count, 3);
    std::vector<int> parents;
    for (int b = 0; b < count; ++b) {
        heads.row(b) = (Vector3(0, 0, b) + beside[b % 3]).transpose();
        tails.row(b) = (Vector3(0, 0, b + 1) + beside[(b + 1) % 3]).transpose();
        parents.push_back(b - 1);
    }
    return {heads, tails, parents, {}, joints};
}

inline std::vector<Joint> limited(int count, double degrees)
{
    std::vector<Joint> joints(count);
    for (Joint& joint : joints)
        joint.most = degrees * shapes::pi / 180;
    return joints;
}

/// A figure of 55 bones with fingers, 1.6 m tall: its hip is bone 0.
struct Figure
{
    std::vector<Vector3> heads, tails;
    std::vector<int> parents;
    int hand[2], foot[2];

    Figure()
    {
        const int hip = add(-1, {0, 0, 0.1});
        int spine = hip;
        for (int k = 0; k < 8; ++k)
            spine = add(spine, {0, 0, 0.06});
        for (int side = 0; side < 2; ++side) {
            const double s = side ? -1 : 1;
            int arm = add(spine, {0.15 * s, 0, 0});
            arm = add(add(arm, {0.28 * s, 0, 0}), {0.26 * s, 0, 0});
            hand[side] = add(arm, {0.1 * s, 0, 0});
            for (int finger = 0; finger < 5; ++finger) {
                int bone = hand[side];
                for (int k = 0; k < 3; ++k)
                    bone = add(bone, {0.03 * s, 0.02 * (finger - 2), 0});
            }
            const int leg = add(add(hip, {0.1 * s, 0, -0.1}), {0, 0, -0.5});
            foot[side] = add(add(leg, {0, -0.02, -0.45}), {0, -0.15, -0.04});
        }
    }

    int count() const { return static_cast<int>(parents.size()); }
    Skeleton skeleton(const std::vector<Joint>& joints = {}) const
    {
        return {shapes::points_of(heads), shapes::points_of(tails), parents, {}, joints};
    }
    /// Every third joint within a cone, and every third one within angles.
    std::vector<Joint> joints() const
    {
        std::vector<Joint> all(count());
        for (int b = 1; b < count(); ++b)
            if (b % 3 == 0) {
                all[b].most = 0.6;
            } else if (b % 3 == 1) {
                all[b].kind = Joint::Kind::angles;
                all[b].lower = {-0.5, -0.3, -0.2};
                all[b].upper = {1.2, 0.3, 0.4};
            }
        return all;
    }

private:
    int add(int parent, const Vector3& along)
    {
        const Vector3 head = parent < 0 ? Vector3(0, 0, 1) : tails[parent];
        parents.push_back(parent);
        heads.push_back(head);
        tails.push_back(head + along);
        return count() - 1;
    }
};

} // namespace sinew::bodies
