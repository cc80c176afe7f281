// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/embedded_energy.h"

#include "native/local_global/graph/rotations.h"
#include "native/operators/fits/rotation_fit.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace sinew {

namespace {

using Unknowns = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;

/// The second derivative of Rot at a rotation is at most twice this, and 0 for turns; a metric with all of it
/// takes more steps.
constexpr double rotation_metric = 4.0;
/// Solves of the start: the factor is in single precision, so each leaves a millionth of the one before.
constexpr int start_solves = 3;

Unknowns of_motion(const HeldMotion& motion, const Vector3& place)
{
    Unknowns own;
    own.topRows<3>() = motion.turn.transpose();
    own.row(3) = motion(place).transpose();
    return own;
}

} // namespace

EmbeddedEnergy::EmbeddedEnergy(const std::vector<std::array<int, 2>>& edges, std::vector<Pull> pulls,
                               int handles, const EmbeddedWeights& weights, const Points& places,
                               const Points& points)
    : size_(static_cast<int>(places.rows())), handles_(handles), weights_(weights), edges_(edges),
      pulls_(std::move(pulls)), nodes_({}, {})
{
    std::map<std::array<int, 3>, int> numbers;
    for (const Pull& pull : pulls_)
        for (const auto& one : pull.shares)
            for (const auto& other : pull.shares)
                if (one.map <= other.map) {
                    const auto [at, is_new] = numbers.try_emplace({pull.handle, one.map, other.map},
                                                                  static_cast<int>(blocks_.size()));
                    if (is_new)
                        blocks_.push_back({pull.handle, one.map, other.map});
                    block_of_.push_back(at->second);
                }
    rest_ = shape(places, points);
    factorize();
}

EmbeddedEnergy::Shape EmbeddedEnergy::shape(const Points& places, const Points& points) const
{
    Shape result{places, points, std::vector<Eigen::Matrix4d>(blocks_.size(), Eigen::Matrix4d::Zero())};
    std::size_t next = 0;
    for (std::size_t p = 0; p < pulls_.size(); ++p) {
        const auto row = [&](const BlendedMaps::Share& share) {
            Eigen::Vector4d b;
            b << (points.row(static_cast<Eigen::Index>(p)) - places.row(share.map)).transpose(), 1.0;
            return Eigen::Vector4d(share.weight * b);
        };
        for (const auto& one : pulls_[p].shares) {
            const Eigen::Vector4d b = pulls_[p].strength * row(one);
            for (const auto& other : pulls_[p].shares)
                if (one.map <= other.map)
                    result.blocks[block_of_[next++]] += b * row(other).transpose();
        }
    }
    return result;
}

void EmbeddedEnergy::factorize()
{
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int j, int k, const Eigen::Matrix4d& block) {
        for (int r = 0; r < 4; ++r)
            for (int c = 0; c < 4; ++c)
                if (block(r, c) != 0.0)
                    entries.emplace_back(4 * j + r, 4 * k + c, block(r, c));
    };
    const Eigen::Vector4d turning(1.0, 1.0, 1.0, 0.0);
    for (int j = 0; j < size_; ++j)
        add(j, j, rotation_metric * weights_.rotation * turning.asDiagonal().toDenseMatrix());
    const Eigen::Vector4d other(0, 0, 0, -1);
    for (const auto& [a, b] : edges_)
        for (const auto& [j, k] : {std::array{a, b}, std::array{b, a}}) {
            Eigen::Vector4d own;
            own << (rest_.places.row(k) - rest_.places.row(j)).transpose(), 1.0;
            const double w = 2.0 * weights_.regularity;
            add(j, j, w * own * own.transpose());
            add(j, k, w * own * other.transpose());
            add(k, j, w * other * own.transpose());
            add(k, k, w * other * other.transpose());
        }
    std::map<std::array<int, 2>, Eigen::Matrix4d> sums; // of all handles
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
        auto& sum = sums.try_emplace({blocks_[k].a, blocks_[k].b}, Eigen::Matrix4d::Zero()).first->second;
        sum += 2.0 * weights_.pulls * rest_.blocks[k];
    }
    for (const auto& [pair, block] : sums) {
        add(pair[0], pair[1], block);
        if (pair[0] != pair[1])
            add(pair[1], pair[0], block.transpose());
    }
    SparseMatrix L(4 * size_, 4 * size_);
    L.setFromTriplets(entries.begin(), entries.end());
    factor_.factorize(L);

    // The rotations of the start: harmonic between the nodes that handles pull.
    std::vector<std::map<int, double>> pulled(static_cast<std::size_t>(size_));
    for (const Pull& pull : pulls_)
        for (const auto& share : pull.shares)
            pulled[share.map][pull.handle] += pull.strength * share.weight;
    GraphHandles held;
    held.idle.assign(static_cast<std::size_t>(size_), 0);
    for (const auto& own : pulled) {
        const auto most = std::ranges::max_element(own, {}, [](const auto& entry) { return entry.second; });
        held.hard.push_back(most == own.end() ? -1 : most->first);
    }
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(size_));
    for (const auto& [a, b] : edges_) {
        neighbours[a].push_back(b);
        neighbours[b].push_back(a);
    }
    GraphEdges graph;
    for (std::vector<int>& own : neighbours) {
        std::ranges::sort(own);
        graph.neighbours.insert(graph.neighbours.end(), own.begin(), own.end());
        graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
    }
    graph.weights.assign(graph.neighbours.size(), 1.0);
    laplacian_ = graph.weights;
    nodes_ = HandleGraph(std::move(graph), std::move(held));
    std::vector<Eigen::Triplet<double>> sides;
    for (const int j : nodes_.free_nodes()) {
        const auto own = static_cast<double>(neighbours[j].size());
        sides.emplace_back(nodes_.place(j), nodes_.place(j), own > 0.0 ? own : 1.0);
        for (const int k : neighbours[j])
            if (nodes_.place(k) >= 0)
                sides.emplace_back(nodes_.place(j), nodes_.place(k), -1.0);
    }
    SparseMatrix M(nodes_.free_count(), nodes_.free_count());
    M.setFromTriplets(sides.begin(), sides.end());
    if (nodes_.free_count() > 0)
        rotation_factor_.factorize(M);
}

EmbeddedProblem::EmbeddedProblem(const EmbeddedEnergy& energy, const EmbeddedEnergy::Shape& shape,
                                 const std::vector<HeldMotion>& motions)
    : energy_(energy), shape_(shape), motions_(motions)
{
}

Points EmbeddedProblem::start() const
{
    Poses poses;
    for (const HeldMotion& motion : motions_) {
        Pose pose = Pose::Zero();
        pose.leftCols<3>() = Matrix3::Identity() + motion.turn;
        poses.push_back(pose);
    }
    std::vector<Matrix3> turns;
    if (energy_.nodes_.free_count() > 0 || !poses.empty())
        for (const Eigen::Quaterniond& rotation :
             blended_rotations(energy_.nodes_, energy_.laplacian_, energy_.rotation_factor_, poses))
            turns.push_back(rotation.toRotationMatrix() - Matrix3::Identity());
    // Begins with the rigid motion of the first handle, so that nothing is left to solve where all move so.
    HeldMotion rigid;
    rigid.turn = fit_rotation(poses[0].leftCols<3>()) - Matrix3::Identity();
    Vector3 middle = Vector3::Zero();
    double count = 0.0;
    for (std::size_t p = 0; p < energy_.pulls_.size(); ++p)
        if (energy_.pulls_[p].handle == 0) {
            middle += shape_.points.row(static_cast<Eigen::Index>(p)).transpose();
            count += 1.0;
        }
    middle /= count;
    rigid.move = motions_[0](middle) - rigid.turn * middle;
    Points x(4 * static_cast<Eigen::Index>(energy_.size()), 3);
    for (int j = 0; j < energy_.size(); ++j)
        x.middleRows<4>(4 * j) = of_motion(rigid, shape_.places.row(j).transpose());
    return solve_for(turns, std::move(x));
}

Points EmbeddedProblem::start_without_rotations() const
{
    return solve_for(std::vector<Matrix3>(static_cast<std::size_t>(energy_.size()), Matrix3::Zero()),
                     Points::Zero(4 * static_cast<Eigen::Index>(energy_.size()), 3));
}

Points EmbeddedProblem::solve_for(const std::vector<Matrix3>& turns, Points x) const
{
    Points gradient, step;
    for (int k = 0; k < start_solves; ++k) {
        gradient.setZero(x.rows(), 3);
        quadratic(x, gradient);
        for (int j = 0; j < energy_.size(); ++j)
            gradient.middleRows<3>(4 * j) +=
                rotation_metric * energy_.weights_.rotation * (x.middleRows<3>(4 * j) - turns[j].transpose());
        energy_.factor_.solve(gradient, step);
        x -= step;
    }
    return x;
}

double EmbeddedProblem::quadratic(const Points& x, Points& gradient) const
{
    const double regularity = energy_.weights_.regularity, pulls = energy_.weights_.pulls;
    double energy = 0.0;
    for (const auto& [a, b] : energy_.edges_) {
        const Eigen::RowVector3d edge = shape_.places.row(b) - shape_.places.row(a),
                                 apart = x.row(4 * a + 3) - x.row(4 * b + 3);
        const Eigen::RowVector3d there = edge * x.middleRows<3>(4 * a) + apart,
                                 back = -edge * x.middleRows<3>(4 * b) - apart;
        energy += regularity * (there.squaredNorm() + back.squaredNorm());
        gradient.middleRows<3>(4 * a) += 2.0 * regularity * edge.transpose() * there;
        gradient.middleRows<3>(4 * b) -= 2.0 * regularity * edge.transpose() * back;
        gradient.row(4 * a + 3) += 2.0 * regularity * (there - back);
        gradient.row(4 * b + 3) -= 2.0 * regularity * (there - back);
    }
    for (std::size_t k = 0; k < energy_.blocks_.size(); ++k) {
        const auto& [handle, a, b] = energy_.blocks_[k];
        const auto left = [&](int j) -> Unknowns {
            return x.middleRows<4>(4 * j) - of_motion(motions_[handle], shape_.places.row(j).transpose());
        };
        const Unknowns at_a = left(a), force = 2.0 * pulls * shape_.blocks[k] * left(b);
        gradient.middleRows<4>(4 * a) += force;
        double share = 0.5;
        if (a != b) {
            gradient.middleRows<4>(4 * b) += 2.0 * pulls * shape_.blocks[k].transpose() * at_a;
            share = 1.0;
        }
        energy += share * at_a.cwiseProduct(force).sum();
    }
    return energy;
}

double EmbeddedProblem::evaluate(const Points& x, Points& gradient)
{
    gradient.setZero(x.rows(), 3);
    double energy = quadratic(x, gradient);
    const double weight = energy_.weights_.rotation;
    for (int j = 0; j < energy_.size(); ++j) {
        const Matrix3 U = x.middleRows<3>(4 * j).transpose();
        // A^T A - I, without a difference of numbers near 1
        const Matrix3 S = U + U.transpose() + U.transpose() * U;
        energy += weight * S.squaredNorm();
        gradient.middleRows<3>(4 * j) += 4.0 * weight * (S + U * S).transpose();
    }
    return energy;
}

void EmbeddedProblem::precondition(const Points& gradient, Points& z) const
{
    energy_.factor_.solve(gradient, z);
}

Poses displacements(const Points& unknowns, const Points& places)
{
    Poses maps(static_cast<std::size_t>(places.rows()));
    for (Eigen::Index j = 0; j < places.rows(); ++j) {
        maps[j].leftCols<3>() = unknowns.middleRows<3>(4 * j).transpose();
        maps[j].col(3) =
            unknowns.row(4 * j + 3).transpose() - maps[j].leftCols<3>() * places.row(j).transpose();
    }
    return maps;
}

} // namespace sinew
