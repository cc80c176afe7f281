// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/bodies/rigid_bodies.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// Of the largest entry of M: what a body without extent gets as its pivot.
constexpr double least_moment = 1e-12;

} // namespace

RigidBodies::RigidBodies(const ArapSystem& graph, std::vector<BodyJoint> joints, const Shapes& rest,
                         int sweeps)
    : size_(graph.size()), free_(graph.free_count()), sweeps_(sweeps), joints_(std::move(joints)),
      first_(2 * static_cast<std::size_t>(free_) + 1, 0), places_(joints_.size(), {-1, -1})
{
    // Slot 2 i + 1 counts the joints within the chunk of body i, slot 2 i + 2 the others, until they are
    // added up.
    const auto each = [&](auto&& visit) { // (slot - 1, joint, side)
        for (int k = 0; k < static_cast<int>(joints_.size()); ++k) {
            const auto [a, b] = joints_[k].body;
            if (a < free_ && b < free_ && a / graph_chunk == b / graph_chunk) {
                visit(2 * std::min(a, b), k, a < b ? 0 : 1);
                continue;
            }
            for (int side : {0, 1})
                if (const int own = joints_[k].body[side]; own < free_)
                    visit(2 * own + 1, k, side);
        }
    };
    each([&](int slot, int, int) { ++first_[slot + 1]; });
    for (std::size_t s = 1; s < first_.size(); ++s)
        first_[s] += first_[s - 1];
    others_.resize(first_.back());
    std::vector<int> next = first_;
    each([&](int slot, int joint, int side) {
        places_[joint][side] = next[slot];
        others_[next[slot]++] = joints_[joint].body[1 - side];
    });
    factorize(rest, graph.position_factor().order());
    lay_out(rest, rest_);
}

void RigidBodies::factorize(const Shapes& rest, const std::vector<int>& order)
{
    std::vector<Eigen::Triplet<double>> entries;
    double largest = 1e-280;
    for (int k = 0; k < static_cast<int>(joints_.size()); ++k) {
        const JointShape shape = rest(k);
        const double share = 2.0 / 3.0 * joints_[k].weight, bending = shape.form.trace();
        const auto [a, b] = joints_[k].body;
        for (int side : {0, 1})
            if (const int own = joints_[k].body[side]; own < free_) {
                const double entry = share * (shape.lever[side].squaredNorm() + bending);
                entries.emplace_back(own, own, entry);
                largest = std::max(largest, entry);
            }
        if (a < free_ && b < free_) {
            const double entry = -share * (shape.lever[0].dot(shape.lever[1]) + bending);
            entries.emplace_back(a, b, entry);
            entries.emplace_back(b, a, entry);
        }
    }
    for (int i = 0; i < free_; ++i)
        entries.emplace_back(i, i, least_moment * largest);
    SparseMatrix M(free_, free_);
    M.setFromTriplets(entries.begin(), entries.end());
    rotation_factor_.factorize(M, order);
}

void RigidBodies::lay_out(const Shapes& shapes, std::vector<double>& numbers) const
{
    numbers.resize(joint_numbers * others_.size() + 1);
    parallel_for(static_cast<int>(joints_.size()), [&](int k) {
        const auto [first, second] = places_[k];
        if (first < 0 && second < 0)
            return;
        const JointShape shape = shapes(k);
        const double w = joints_[k].weight;
        const Matrix3 B = w * shape.form;
        for (int side : {0, 1})
            if (places_[k][side] >= 0) {
                double* to = numbers.data() + joint_numbers * static_cast<std::size_t>(places_[k][side]);
                for (const Vector3& lever : {shape.lever[side], shape.lever[1 - side]})
                    to = std::copy(lever.data(), lever.data() + 3, to);
                for (int row = 0; row < 3; ++row)
                    for (int column = row; column < 3; ++column)
                        *to++ = B(row, column);
                *to = w;
            }
    });
}

double RigidBodies::scale(const std::vector<double>& numbers) const
{
    return 0.5 * parallel_sum(static_cast<int>(others_.size()), [&](int a) {
               const double* const d = numbers.data() + joint_numbers * static_cast<std::size_t>(a);
               return d[12] * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + d[6] + d[9] + d[11];
           });
}

} // namespace sinew
