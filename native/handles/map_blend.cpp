// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/map_blend.h"

#include "native/core/dense.h"
#include "native/operators/fits/rotation_fit.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr double half_turn = 1e-9; ///< the real part of a quaternion that counts as half a turn

} // namespace

std::vector<std::vector<int>> handle_patches(const SurfaceMesh& mesh, const Regions& regions)
{
    std::vector<std::vector<int>> handles_of(mesh.vertex_count());
    for (const auto& [vertex, handle] : regions.constraints())
        handles_of[vertex].push_back(handle);
    std::vector<std::vector<int>> patches(regions.handle_count());
    for (const Triangle& t : mesh.triangles())
        for (int v : t)
            for (int h : handles_of[v])
                patches[h].insert(patches[h].end(), t.begin(), t.end());
    return patches;
}

std::vector<Matrix3> linear_maps(const Targets& targets, const std::vector<std::vector<int>>& patches)
{
    std::vector<Matrix3> maps;
    for (const Pose& pose : targets.poses)
        maps.emplace_back(pose.leftCols<3>());
    if (!targets.incoming || !targets.from_rest)
        return maps;
    for (std::size_t h = 0; h < maps.size(); ++h) {
        if (!(*targets.from_rest)[h] || patches[h].empty())
            continue;
        const auto count = static_cast<double>(patches[h].size());
        Vector3 rest = Vector3::Zero(), now = Vector3::Zero();
        for (int v : patches[h]) {
            rest += targets.rest.row(v).transpose() / count;
            now += targets.incoming->row(v).transpose() / count;
        }
        Matrix3 S = Matrix3::Zero();
        for (int v : patches[h])
            S += (targets.incoming->row(v).transpose() - now) *
                 (targets.rest.row(v).transpose() - rest).transpose();
        maps[h] *= fit_rotation(S).transpose();
    }
    return maps;
}

Polar::Polar(const Matrix3& A)
{
    const double largest = A.cwiseAbs().maxCoeff(); // whose square may be no number any more
    R = fit_rotation(largest > 0 ? Matrix3(A / largest) : A);
    S = R.transpose() * A;
    S = (0.5 * (S + S.transpose())).eval();
}

Eigen::Quaterniond mean_rotation(std::span<const Eigen::Quaterniond> rotations)
{
    Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
    for (const Eigen::Quaterniond& q : rotations)
        sum += q.coeffs() * q.coeffs().transpose();
    const Eigenvectors<4> eigen = eigenvectors(sum);
    const double gap = eigen.values[3] - eigen.values[2];
    if (gap > half_turn * static_cast<double>(rotations.size()))
        return Eigen::Quaterniond(Eigen::Vector4d(eigen.vectors.col(3)));
    return rotations.front();
}

bool opposed(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b)
{
    return std::abs(a.dot(b)) < half_turn;
}

Vector3 rotation_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to)
{
    const Eigen::Quaterniond q = from.conjugate() * to;
    double side = q.w();
    for (int axis = 0; axis < 3 && std::abs(side) < half_turn; ++axis)
        if (std::abs(q.vec()[axis]) > 1e-6)
            side = q.vec()[axis];
    const Vector3 sine = side < 0 ? Vector3(-q.vec()) : Vector3(q.vec());
    const double length = sine.norm(), angle = 2 * std::atan2(length, std::abs(q.w()));
    return length > 0 ? Vector3(angle / length * sine) : Vector3::Zero();
}

MapBlend::MapBlend(const HandleGroups& groups, const std::vector<Matrix3>& maps)
    : values_(groups.part_handle_count(), numbers)
{
    const auto put = [this](int part_handle, const Vector3& turn, const Matrix3& S) {
        values_.row(part_handle) << turn.transpose(), S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
    };
    for (int g = 0; g < groups.count(); ++g) {
        std::vector<Polar> polar;
        std::vector<Eigen::Quaterniond> turns;
        bool alike = true;
        for (int part_handle = groups.offsets[g]; part_handle < groups.offsets[g + 1]; ++part_handle) {
            const Matrix3& map = maps[groups.handles[part_handle]];
            alike = alike && map == maps[groups.handles[groups.offsets[g]]];
            polar.emplace_back(map);
            turns.emplace_back(polar.back().R);
        }
        const Eigen::Quaterniond mean = mean_rotation(turns);
        alike_.push_back(alike);
        decided_.push_back(
            std::ranges::any_of(turns, [&](const Eigen::Quaterniond& q) { return opposed(mean, q); }));
        means_.push_back(alike ? maps[groups.handles[groups.offsets[g]]] : mean.toRotationMatrix());
        for (std::size_t k = 0; k < polar.size(); ++k)
            put(groups.offsets[g] + static_cast<int>(k), rotation_between(mean, turns[k]), polar[k].S);
    }
}

int MapBlend::half_turns(const HandleGroups& groups) const
{
    if (std::ranges::none_of(decided_, [](char decided) { return decided; }))
        return 0;
    return static_cast<int>(
        std::ranges::count_if(groups.group, [this](int g) { return g >= 0 && decided_[g]; }));
}

} // namespace sinew
