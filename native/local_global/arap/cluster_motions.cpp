// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/cluster_motions.h"

#include "native/core/parallel.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr int grain = 32; ///< clusters per parallel chunk
constexpr double least_share = 0.01;
constexpr double least_pivot = 1e-10; ///< as a share of the diagonal

using Row3 = Eigen::RowVector3d;

Matrix3 cross_matrix(const Vector3& v)
{
    return Matrix3{{0.0, -v.z(), v.y()}, {v.z(), 0.0, -v.x()}, {-v.y(), v.x(), 0.0}};
}

/// Begins of the lists of `count` owners, of which owner(k) owns thing k.
template <class Owner>
std::vector<int> begins(int count, int things, Owner&& owner)
{
    std::vector<int> first(count + 1, 0);
    for (int k = 0; k < things; ++k)
        if (const int at = owner(k); at >= 0)
            ++first[at + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    return first;
}

/// Two clusters that touch a third one and each other; or one, if `other` is -1.
struct Corner
{
    int one, other;
    Vector3 to_one, to_other;
    double a, b, c; ///< the inverse (a b; b c) of their products
};

std::vector<Corner> corners_at(int p, const HandleGraph& clusters, const Points& places)
{
    const GraphEdges& edges = clusters.edges();
    const auto first = edges.neighbours.begin();
    std::vector<Corner> corners;
    for (int k = edges.offsets[p]; k < edges.offsets[p + 1]; ++k)
        for (int l = k + 1; l < edges.offsets[p + 1]; ++l) {
            const int q = edges.neighbours[k], r = edges.neighbours[l];
            if (!std::binary_search(first + edges.offsets[q], first + edges.offsets[q + 1], r))
                continue;
            const Vector3 e = places.row(q) - places.row(p), f = places.row(r) - places.row(p);
            const double ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm(), area = ee * ff - ef * ef;
            if (area > 1e-6 * ee * ff)
                corners.push_back({q, r, e, f, ff / area, -ef / area, ee / area});
        }
    if (!corners.empty())
        return corners;
    for (int k = edges.offsets[p]; k < edges.offsets[p + 1]; ++k) { // a chain of clusters
        const int q = edges.neighbours[k];
        const Vector3 e = places.row(q) - places.row(p);
        if (const double ee = e.squaredNorm(); ee > 0)
            corners.push_back({q, -1, e, Vector3::Zero(), 1.0 / ee, 0.0, 0.0});
    }
    return corners;
}

/// A sum over edges for a pair of clusters.
struct Block
{
    int high, low;
    double moves = 0.0;              ///< a_high a_low
    Vector3 high_low = Vector3::Zero(), low_high = Vector3::Zero(); ///< a_high b_low, a_low b_high
    Matrix3 turns = Matrix3::Zero();

    void add(const Block& other)
    {
        moves += other.moves;
        high_low += other.high_low;
        low_high += other.low_high;
        turns += other.turns;
    }
};

} // namespace

ClusterMotions::ClusterMotions(const ArapSystem& graph, const Points& rest, std::vector<int> label,
                               const HandleGraph& clusters, std::shared_ptr<const SingleFactor> metric)
    : free_(clusters.free_count()), unknowns_(6 * free_), label_(std::move(label)), metric_(std::move(metric))
{
    if (empty())
        return;
    const int count = clusters.size(), nodes = graph.size();
    first_member_ = begins(count, nodes, [&](int i) { return label_[i]; });
    members_.resize(first_member_.back());
    std::vector<int> next(first_member_.begin(), first_member_.end() - 1);
    Points places = Points::Zero(count, 3);
    for (int i = 0; i < nodes; ++i)
        if (label_[i] >= 0) {
            members_[next[label_[i]]++] = i;
            places.row(label_[i]) += rest.row(i);
        }
    for (int p = 0; p < count; ++p)
        places.row(p) /= std::max(1, first_member_[p + 1] - first_member_[p]);

    label_.resize(graph.free_count());
    weigh(rest, places, clusters);
    first_node_ = begins(free_, static_cast<int>(shares_.size()),
                         [&](int k) { return shares_[k].cluster < free_ ? shares_[k].cluster : -1; });
    moved_.resize(first_node_.back());
    next.assign(first_node_.begin(), first_node_.end() - 1);
    for (int i = 0; i < graph.free_count(); ++i)
        for (int k = first_share_[i]; k < first_share_[i + 1]; ++k)
            if (shares_[k].cluster < free_)
                moved_[next[shares_[k].cluster]++] = {i, shares_[k].weight};

    if (metric_)
        return;
    const SparseMatrix K = hessian(graph, rest, places);
    std::vector<Eigen::Triplet<double>> pattern;
    for (int p = 0; p < free_; ++p) {
        pattern.emplace_back(p, p, 1.0);
        for (SparseMatrix::InnerIterator it(K, 6 * p); it; ++it)
            if (const int q = static_cast<int>(it.row()) / 6; q > p && it.row() % 6 == 0) {
                pattern.emplace_back(p, q, 1.0);
                pattern.emplace_back(q, p, 1.0);
            }
    }
    SparseMatrix touching(free_, free_);
    touching.setFromTriplets(pattern.begin(), pattern.end());
    std::vector<int> order;
    for (int p : fill_reducing_order(touching))
        for (int k = 0; k < 6; ++k)
            order.push_back(6 * p + k);
    SingleFactor factor;
    factor.factorize(K, order);
    metric_ = std::make_shared<const SingleFactor>(std::move(factor));
}

/// The weights of a node are barycentric: in the triangle of its own cluster and of two that touch it and
/// each other, the one that has the node best.
void ClusterMotions::weigh(const Points& rest, const Points& places, const HandleGraph& clusters)
{
    const int nodes = static_cast<int>(label_.size());
    std::vector<std::array<Share, 3>> rows(nodes);
    parallel_for(
        clusters.free_count(),
        [&](int p) {
            const std::vector<Corner> corners = corners_at(p, clusters, places);
            for (int m = first_member_[p]; m < first_member_[p + 1]; ++m) {
                const int i = members_[m];
                const Vector3 v = rest.row(i) - places.row(p);
                double best = -1e300, u = 0.0, w = 0.0;
                int one = -1, other = -1;
                for (const Corner& corner : corners) {
                    const double e = v.dot(corner.to_one), f = v.dot(corner.to_other);
                    const double s = corner.a * e + corner.b * f, t = corner.b * e + corner.c * f;
                    const double off = (v - s * corner.to_one - t * corner.to_other).norm() /
                                       (corner.to_one.norm() + corner.to_other.norm());
                    const double score = std::min({s, t, 1 - s - t, 0.0}) - off;
                    if (score > best + 1e-6) { // of equally good ones, the first
                        best = score;
                        u = s, w = t;
                        one = corner.one, other = corner.other;
                    }
                }
                const auto kept = [](double weight) { return weight > least_share ? weight : 0.0; };
                const double own = kept(1 - u - w), of_one = kept(u), of_other = kept(w);
                const double sum = own + of_one + of_other;
                rows[i] = {Share{p, own / sum}, Share{one, of_one / sum}, Share{other, of_other / sum}};
            }
        },
        grain);
    first_share_ = {0};
    for (const std::array<Share, 3>& row : rows) {
        for (const Share& share : row)
            if (share.cluster >= 0 && share.weight > 0)
                shares_.push_back(share);
        first_share_.push_back(static_cast<int>(shares_.size()));
    }
}

SparseMatrix ClusterMotions::hessian(const ArapSystem& graph, const Points& rest, const Points& places) const
{
    const GraphEdges& edges = graph.nodes().edges();
    const std::vector<double>& laplacian = graph.laplacian();
    const double smoothing = 2 * graph.cells().smoothing;
    const int count = static_cast<int>(first_member_.size()) - 1;
    std::vector<std::vector<Block>> parts(count);
    const auto row_of = [&](int i) {
        Vector3 mean = Vector3::Zero();
        for (int k = first_share_[i]; k < first_share_[i + 1]; ++k)
            mean += shares_[k].weight * places.row(shares_[k].cluster).transpose();
        return mean;
    };
    const int free = graph.free_count();
    std::vector<double> pulled(free, 0.0);
    for (const GraphPull& pull : graph.nodes().pulls())
        pulled[pull.node] += pull.stiffness;
    parallel_for(
        count,
        [&](int p) {
            std::vector<Block>& blocks = parts[p];
            std::array<std::size_t, 36> last{}; // where the last edge found its pairs; most edges are alike
            const auto block = [&](int high, int low, std::size_t& at) -> Block& {
                const auto is_it = [&](const Block& b) { return b.high == high && b.low == low; };
                if (at < blocks.size() && is_it(blocks[at]))
                    return blocks[at];
                at = std::ranges::find_if(blocks, is_it) - blocks.begin();
                if (at == blocks.size())
                    blocks.push_back({high, low});
                return blocks[at];
            };
            struct Entry
            {
                int cluster;
                double a;
                Vector3 b;
            };
            std::array<Entry, 6> entries;
            int used = 0;
            const auto entry = [&](int cluster) -> Entry& {
                for (int k = 0; k < used; ++k)
                    if (entries[k].cluster == cluster)
                        return entries[k];
                entries[used] = {cluster, 0.0, Vector3::Zero()};
                return entries[used++];
            };
            const auto take = [&](int i, double sign, const Vector3& e) {
                if (i >= free)
                    return;
                const Vector3 x = rest.row(i).transpose(), mean = row_of(i);
                for (int k = first_share_[i]; k < first_share_[i + 1]; ++k) {
                    const auto [cluster, weight] = shares_[k];
                    if (cluster >= free_)
                        continue;
                    Entry& to = entry(cluster);
                    to.a += sign * weight;
                    to.b += weight * (sign * (x - 0.5 * (places.row(cluster).transpose() + mean)) - 0.5 * e);
                }
            };
            const auto close = [&](double weight, const Matrix3& turning) {
                for (int k = 0; k < used; ++k)
                    for (int l = 0; l < used; ++l) {
                        const Entry &high = entries[k], &low = entries[l];
                        if (high.cluster < low.cluster)
                            continue;
                        Block& to = block(high.cluster, low.cluster, last[6 * k + l]);
                        to.moves += weight * high.a * low.a;
                        to.high_low += weight * high.a * low.b;
                        to.low_high += weight * low.a * high.b;
                        to.turns -= weight * low.b * high.b.transpose();
                        to.turns.diagonal().array() += weight * high.b.dot(low.b);
                        to.turns += (weight * high.a * low.a) * turning;
                    }
                used = 0;
            };
            for (int m = first_member_[p]; m < first_member_[p + 1]; ++m) {
                const int i = members_[m];
                for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                    const int j = edges.neighbours[a];
                    if (j <= i || (i >= free && j >= free))
                        continue;
                    const Vector3 e = rest.row(i) - rest.row(j);
                    take(i, 1.0, e);
                    take(j, -1.0, e);
                    Matrix3 turning = -0.25 * e * e.transpose();
                    turning.diagonal().array() += smoothing + 0.25 * e.squaredNorm();
                    close(laplacian[a], turning);
                }
                if (i < free && pulled[i] > 0) {
                    take(i, 1.0, Vector3::Zero());
                    close(pulled[i], Matrix3::Zero());
                }
            }
        },
        grain);

    std::vector<std::vector<Block>> rows(free_);
    for (const std::vector<Block>& part : parts)
        for (const Block& block : part) {
            std::vector<Block>& row = rows[block.high];
            const auto same = std::ranges::find(row, block.low, &Block::low);
            if (same == row.end())
                row.push_back(block);
            else
                same->add(block);
        }
    std::vector<Eigen::Triplet<double>> triplets;
    for (const std::vector<Block>& row : rows)
        for (const Block& block : row) {
            Eigen::Matrix<double, 6, 6> all;
            // w x b = -[b]x w
            all << block.moves * Matrix3::Identity(), -cross_matrix(block.high_low),
                cross_matrix(block.low_high), block.turns;
            for (int k = 0; k < 6; ++k)
                for (int l = 0; l < 6; ++l)
                    if (block.high > block.low || k >= l)
                        triplets.emplace_back(
                            6 * block.high + k, 6 * block.low + l,
                            all(k, l) * (block.high == block.low && k == l ? 1 + least_pivot : 1.0));
        }
    SparseMatrix K(unknowns_, unknowns_);
    K.setFromTriplets(triplets.begin(), triplets.end());
    return K;
}

double ClusterMotions::solve(const Points& x, const double* points, const double* rotations,
                             const Points& gradient, const Points& torque, double torque_share,
                             Motion& motion) const
{
    const int count = static_cast<int>(first_member_.size()) - 1;
    const int nodes = static_cast<int>(label_.size());
    motion.places.resize(count, 3);
    motion.frames.resize(free_);
    parallel_for(
        count,
        [&](int p) {
            Row3 sum = Row3::Zero();
            Matrix3 turned = Matrix3::Zero();
            for (int m = first_member_[p]; m < first_member_[p + 1]; ++m) {
                const std::size_t i = members_[m];
                sum += Eigen::Map<const Row3>(points + 3 * i);
                if (p < free_)
                    turned += Eigen::Map<const Matrix3>(rotations + 9 * i);
            }
            motion.places.row(p) = sum / std::max(1, first_member_[p + 1] - first_member_[p]);
            if (p < free_)
                motion.frames[p] = fit_rotation(turned);
        },
        grain);
    motion.offsets.resize(nodes, 3);
    motion.forces.resize(nodes, 3);
    parallel_for(nodes, [&](int i) {
        Row3 mean = Row3::Zero();
        for (int k = first_share_[i]; k < first_share_[i + 1]; ++k)
            mean += shares_[k].weight * motion.places.row(shares_[k].cluster);
        const Row3 offset = x.row(i) - 0.5 * mean;
        motion.offsets.row(i) = offset;
        motion.forces.row(i) = offset.cross(gradient.row(i));
        if (torque.size() > 0)
            motion.forces.row(i) -= torque_share * torque.row(i);
    });
    motion.pushes.resize(unknowns_, 1);
    parallel_for(
        free_,
        [&](int p) {
            Row3 force = Row3::Zero(), turn = Row3::Zero();
            for (int m = first_node_[p]; m < first_node_[p + 1]; ++m) {
                const auto [i, weight] = moved_[m];
                force += weight * gradient.row(i);
                turn += weight * motion.forces.row(i);
            }
            turn -= 0.5 * motion.places.row(p).cross(force);
            motion.pushes.block<3, 1>(6 * p, 0) = motion.frames[p].transpose() * force.transpose();
            motion.pushes.block<3, 1>(6 * p + 3, 0) = motion.frames[p].transpose() * turn.transpose();
        },
        grain);
    metric_->solve(motion.pushes, motion.solution);
    double longest = 1.0;
    for (int p = 0; p < free_; ++p)
        longest = std::max(longest, motion.solution.block<3, 1>(6 * p + 3, 0).norm());
    motion.solution /= longest;
    return motion.pushes.cwiseProduct(motion.solution).sum();
}

void ClusterMotions::scale(double share, Motion& motion) const
{
    motion.maps.resize(free_);
    motion.turns.resize(free_, 3);
    parallel_for(
        free_,
        [&](int p) {
            const Vector3 y = -share * (motion.frames[p] * motion.solution.block<3, 1>(6 * p, 0));
            const Vector3 w = -share * (motion.frames[p] * motion.solution.block<3, 1>(6 * p + 3, 0));
            // Cayley's formula: a rotation by w to second order
            const Vector3 h = 0.5 * w;
            const Matrix3 H = cross_matrix(h);
            const Matrix3 turn = (2.0 / (1.0 + h.squaredNorm())) * (H + H * H); // less the identity
            motion.maps[p].leftCols<3>() = turn;
            motion.maps[p].col(3) = y - 0.5 * (turn * motion.places.row(p).transpose());
            motion.turns.row(p) = w.transpose();
        },
        grain);
}

void ClusterMotions::move(const Motion& motion, int i, const Row3& x, Row3& to, Row3& turn) const
{
    Vector3 by = Vector3::Zero();
    turn.setZero();
    const Vector3 offset = motion.offsets.row(i).transpose();
    for (int k = first_share_[i]; k < first_share_[i + 1]; ++k) {
        const auto [p, weight] = shares_[k];
        if (p >= free_)
            continue;
        by += weight * (motion.maps[p].leftCols<3>() * offset + motion.maps[p].col(3));
        turn += weight * motion.turns.row(p);
    }
    to = x + by.transpose();
}

} // namespace sinew
