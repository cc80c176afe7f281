// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap_energy.h"

#include "native/core/parallel.h"
#include "native/operators/rotation_fit.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr int grain = 512; ///< nodes a parallel chunk: some 50 us of work
/// A cell whose edges lie on one line leaves its turn about that line open. This share of the
/// rotation it had closes it; at the minimum, where rotations rest, it changes nothing.
constexpr double tie = 1e-8;

constexpr int lanes = 4, columns = 12;

/// Places along a curve that fills the bounding box: G. M. Morton, 1966.
std::vector<std::uint64_t> morton_codes(const Points& points)
{
    constexpr int bits = 21;
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const double extent = std::max((points.colwise().maxCoeff() - low).maxCoeff(), 1e-300);
    std::vector<std::uint64_t> codes(points.rows(), 0);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const auto cell =
                static_cast<std::uint64_t>((points(i, axis) - low[axis]) / extent * ((1 << bits) - 1));
            for (int bit = 0; bit < bits; ++bit)
                codes[i] |= (cell >> bit & 1) << (3 * bit + axis);
        }
    return codes;
}

std::vector<double> widened(const PointsView& points)
{
    std::vector<double> result(lanes * static_cast<std::size_t>(points.rows()), 0.0);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int k = 0; k < 3; ++k)
            result[lanes * i + k] = points(i, k);
    return result;
}

} // namespace

void ArapGraph::set_metric()
{
    metric.assign(weights.size(), 0.0);
    if (!has_rims()) {
        for (int i = 0; i < size; ++i)
            for (int a = offsets[i]; a < offsets[i + 1]; ++a)
                metric[a] = weights[a] * edge_rigidity(i, neighbours[a]);
        return;
    }
    for (int i = 0; i < size; ++i) {
        const auto first = neighbours.begin() + offsets[i];
        const auto last = neighbours.begin() + offsets[i + 1];
        const auto entry = [&](int j) -> double& {
            return metric[std::lower_bound(first, last, j) - neighbours.begin()];
        };
        for (int k = wing_offsets[i]; k < wing_offsets[i + 1]; ++k) {
            const ArapWing& t = wings[k];
            const double mean = (rigidity[i] + rigidity[t.b] + rigidity[t.c]) / 3.0;
            if (t.b != i) // a face may name a vertex twice
                entry(t.b) += mean * t.to_b;
            if (t.c != i)
                entry(t.c) += mean * t.to_c;
        }
    }
}

void ArapGraph::factorize(const Points& rest)
{
    place.assign(size, -1);
    free_nodes.clear();
    for (int i = 0; i < size; ++i)
        if (hard[i] < 0 && !idle[i]) {
            place[i] = static_cast<int>(free_nodes.size());
            free_nodes.push_back(i);
        }

    std::vector<Eigen::Triplet<double>> L, M;
    std::vector<double> moment(size, 0.0); // of each cell, 2/3 sum w |e|^2
    const auto square = [&](int i, int j) { return (rest.row(i) - rest.row(j)).squaredNorm(); };
    for (int i = 0; i < size; ++i) {
        double spread = 0.0;
        for (int a = offsets[i]; a < offsets[i + 1]; ++a) {
            const int j = neighbours[a];
            if (place[i] >= 0) {
                L.emplace_back(place[i], place[i], metric[a]);
                if (place[j] >= 0)
                    L.emplace_back(place[i], place[j], -metric[a]);
            }
            if (smoothing > 0) {
                M.emplace_back(i, j, -4 * smoothing * weights[a] * edge_rigidity(i, j));
                M.emplace_back(i, i, 4 * smoothing * weights[a] * edge_rigidity(i, j));
            }
            if (!has_rims())
                spread += weights[a] * square(i, j);
        }
        if (has_rims())
            for (int k = wing_offsets[i]; k < wing_offsets[i + 1]; ++k) {
                const ArapWing& t = wings[k];
                spread += t.to_b * square(i, t.b) + t.to_c * square(i, t.c) + t.across * square(t.b, t.c);
            }
        moment[i] = 2.0 / 3.0 * rigidity[i] * spread;
    }
    for (const ArapPull& pull : pulls)
        L.emplace_back(place[pull.node], place[pull.node], pull.stiffness);
    SparseMatrix matrix(free_nodes.size(), free_nodes.size());
    matrix.setFromTriplets(L.begin(), L.end());
    position_factor.factorize(matrix);

    if (smoothing > 0) {
        // A node without edges, or of a part shrunk to a point, still needs a pivot.
        const double least = 1e-12 * std::max(1e-280, *std::ranges::max_element(moment));
        for (int i = 0; i < size; ++i)
            M.emplace_back(i, i, moment[i] + least);
        SparseMatrix field(size, size);
        field.setFromTriplets(M.begin(), M.end());
        rotation_factor.factorize(field);
    }
}

std::vector<int> ArapGraph::renumber(const Points& rest)
{
    const std::vector<std::uint64_t> codes = morton_codes(rest);
    std::vector<int> old(size);
    std::iota(old.begin(), old.end(), 0);
    std::ranges::sort(old, {}, [&](int i) { return std::pair(codes[i], i); });
    std::vector<int> renamed(size), free_renamed(free_nodes.size());
    for (int i = 0; i < size; ++i)
        renamed[old[i]] = i;

    ArapGraph sorted;
    sorted.size = size;
    sorted.smoothing = smoothing;
    sorted.offsets.assign(1, 0);
    if (has_rims())
        sorted.wing_offsets.assign(1, 0);
    for (int i : old) {
        std::vector<std::pair<int, int>> edges;
        for (int a = offsets[i]; a < offsets[i + 1]; ++a)
            edges.emplace_back(renamed[neighbours[a]], a);
        std::ranges::sort(edges);
        for (const auto& [j, a] : edges) {
            sorted.neighbours.push_back(j);
            sorted.weights.push_back(weights[a]);
            sorted.metric.push_back(metric[a]);
        }
        sorted.offsets.push_back(static_cast<int>(sorted.neighbours.size()));
        if (has_rims()) {
            for (int k = wing_offsets[i]; k < wing_offsets[i + 1]; ++k) {
                ArapWing wing = wings[k];
                wing.b = renamed[wing.b];
                wing.c = renamed[wing.c];
                sorted.wings.push_back(wing);
            }
            sorted.wing_offsets.push_back(static_cast<int>(sorted.wings.size()));
        }
        sorted.rigidity.push_back(rigidity[i]);
        sorted.hard.push_back(hard[i]);
        sorted.idle.push_back(idle[i]);
        sorted.place.push_back(-1);
        if (place[i] >= 0) {
            sorted.place.back() = free_renamed[place[i]] = static_cast<int>(sorted.free_nodes.size());
            sorted.free_nodes.push_back(renamed[i]);
        }
    }
    sorted.pulls = pulls;
    for (ArapPull& pull : sorted.pulls)
        pull.node = renamed[pull.node];
    sorted.position_factor = std::move(position_factor);
    sorted.position_factor.rename(free_renamed);
    sorted.rotation_factor = std::move(rotation_factor);
    sorted.rotation_factor.rename(renamed);
    *this = std::move(sorted);
    return old;
}

ArapProblem::ArapProblem(const ArapGraph& graph, const PointsView& base, const Points& targets,
                         const Points& pulls)
    : graph_(graph), kernels_(arap_kernels()), pulls_(pulls), base_(widened(base)),
      points_(widened(view(targets))), view_{graph.offsets.data(),
                                             graph.neighbours.data(),
                                             graph.weights.data(),
                                             graph.rigidity.data(),
                                             graph.has_rims() ? graph.wing_offsets.data() : nullptr,
                                             graph.wings.data(),
                                             graph.place.data(),
                                             graph.idle.data(),
                                             base_.data(),
                                             points_.data(),
                                             graph.smoothing}
{
    for (Matrices& rotations : rotations_)
        rotations.resize(columns * static_cast<std::size_t>(graph.size));
    for (int i = 0; i < graph.size; ++i)
        for (Matrices& rotations : rotations_) // idle nodes keep theirs in all of them
            rotations[columns * static_cast<std::size_t>(i)] =
                rotations[columns * static_cast<std::size_t>(i) + 5] =
                    rotations[columns * static_cast<std::size_t>(i) + 10] = 1.0;
    move_to(free_rows(base));
    scale_ = parallel_sum(graph.size, [&](int i) {
        double sum = 0.0;
        for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a)
            sum += graph_.weights[a] * graph_.rigidity[i] *
                   (base.row(i) - base.row(graph_.neighbours[a])).squaredNorm();
        return sum;
    });
}

Matrix3 ArapProblem::rotation(int i) const
{
    Matrix3 R;
    const double* const from = rotations_[current_].data() + columns * static_cast<std::size_t>(i);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            R(row, column) = from[lanes * column + row];
    return R;
}

void ArapProblem::set_rotation(int i, const Matrix3& R)
{
    double* const to = rotations_[current_].data() + columns * static_cast<std::size_t>(i);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            to[lanes * column + row] = R(row, column);
}

void ArapProblem::move_to(const Points& x)
{
    parallel_for(static_cast<int>(graph_.free_nodes.size()), [&](int f) {
        double* const point = points_.data() + lanes * static_cast<std::size_t>(graph_.free_nodes[f]);
        for (int k = 0; k < 3; ++k)
            point[k] = x(f, k);
    });
}

Points ArapProblem::place(const Points& x)
{
    move_to(x);
    Points all(graph_.size, 3);
    for (int i = 0; i < graph_.size; ++i)
        for (int k = 0; k < 3; ++k)
            all(i, k) = points_[lanes * static_cast<std::size_t>(i) + k];
    return all;
}

Points ArapProblem::free_rows(const PointsView& all) const
{
    Points x(graph_.free_nodes.size(), 3);
    for (std::size_t f = 0; f < graph_.free_nodes.size(); ++f)
        x.row(f) = all.row(graph_.free_nodes[f]);
    return x;
}

int ArapProblem::spare(int used) const
{
    int set = 0;
    while (set == kept_ || set == used)
        ++set;
    return set;
}

void ArapProblem::fit(const double* S, int begin, int end, const Matrices& before, double tie,
                      Matrices& after) const
{
    bool safe[grain];
    std::array<double, columns * grain> fitted;
    const std::size_t first = columns * static_cast<std::size_t>(begin);
    kernels_.fit(S, before.data() + first, tie, end - begin, fitted.data(), safe);
    for (int i = begin; i < end; ++i) {
        const double* const R = fitted.data() + columns * static_cast<std::size_t>(i - begin);
        double* const to = after.data() + columns * static_cast<std::size_t>(i);
        if (graph_.idle[i])
            continue;
        if (safe[i - begin]) {
            std::copy_n(R, columns, to);
            continue;
        }
        using Columns = Eigen::Map<const Eigen::Matrix<double, 3, 3>, 0, Eigen::OuterStride<lanes>>;
        const Matrix3 own = Columns(S + columns * static_cast<std::size_t>(i - begin));
        const Matrix3 last = Columns(before.data() + columns * static_cast<std::size_t>(i));
        const Matrix3 best = fit_rotation_svd(own + tie * own.norm() * last);
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                to[lanes * column + row] = best(row, column);
    }
}

/// One linearised step of all rotations together: (moment + 4 alpha A L) omega = torque. The
/// cell-by-cell fit alone passes a turn on by one ring an iteration.
void ArapProblem::turn_rotation_field()
{
    const Matrices& before = rotations_[current_];
    torque_.resize(graph_.size, 3);
    parallel_chunks(graph_.size, grain, [&](int begin, int end) {
        std::array<double, columns * grain> pull;
        const std::size_t first = columns * static_cast<std::size_t>(begin);
        std::copy(covariances_.data() + first, covariances_.data() + columns * static_cast<std::size_t>(end),
                  pull.data());
        kernels_.add_neighbours(view_, before.data(), begin, end, pull.data());
        kernels_.torques(pull.data(), before.data() + first, end - begin,
                         torque_.data() + 3 * static_cast<std::size_t>(begin));
    });
    graph_.rotation_factor.solve(torque_, torque_);
    const int turned = current_ == kept_ ? spare(current_) : current_;
    parallel_chunks(graph_.size, grain, [&](int begin, int end) {
        const std::size_t first = columns * static_cast<std::size_t>(begin);
        kernels_.turn(torque_.data() + 3 * static_cast<std::size_t>(begin), before.data() + first,
                      end - begin, rotations_[turned].data() + first);
    });
    current_ = turned;
}

void ArapProblem::fit_rotations(const Points& x)
{
    move_to(x);
    const Matrices& before = rotations_[current_];
    const int next = current_ == kept_ ? spare(current_) : current_;
    parallel_chunks(graph_.size, grain, [&](int begin, int end) {
        std::array<double, columns * grain> S;
        kernels_.covariances(view_, begin, end, S.data());
        fit(S.data(), begin, end, before, tie, rotations_[next]);
    });
    current_ = next;
}

double ArapProblem::energy_and_gradient(Points& gradient) const
{
    gradient.resize(graph_.free_nodes.size(), 3);
    const int chunks = (graph_.size + grain - 1) / grain;
    std::vector<double> parts(chunks);
    parallel_chunks(graph_.size, grain, [&](int begin, int end) {
        parts[begin / grain] =
            kernels_.energy(view_, rotations_[current_].data(), begin, end, gradient.data());
    });
    double energy = std::accumulate(parts.begin(), parts.end(), 0.0) / graph_.energy_factor();

    for (std::size_t k = 0; k < graph_.pulls.size(); ++k) {
        const ArapPull& pull = graph_.pulls[k];
        const Eigen::Map<const Eigen::RowVector3d> at(points_.data() +
                                                      lanes * static_cast<std::size_t>(pull.node));
        const Eigen::RowVector3d gap = at - pulls_.row(k);
        energy += 0.5 * pull.stiffness * gap.squaredNorm();
        gradient.row(graph_.place[pull.node]) += pull.stiffness * gap;
    }
    return energy;
}

double ArapProblem::evaluate(const Points& x, Points& gradient)
{
    if (graph_.smoothing > 0) {
        move_to(x);
        covariances_.resize(columns * static_cast<std::size_t>(graph_.size));
        parallel_chunks(graph_.size, grain, [&](int begin, int end) {
            kernels_.covariances(view_, begin, end,
                                 covariances_.data() + columns * static_cast<std::size_t>(begin));
        });
        turn_rotation_field();
        const Matrices& before = rotations_[current_];
        const int next = spare(current_);
        parallel_chunks(graph_.size, grain, [&](int begin, int end) {
            double* const S = covariances_.data() + columns * static_cast<std::size_t>(begin);
            kernels_.add_neighbours(view_, before.data(), begin, end, S);
            fit(S, begin, end, before, 0.0, rotations_[next]);
        });
        current_ = next;
    } else {
        fit_rotations(x);
    }
    return energy_and_gradient(gradient);
}

void ArapProblem::precondition(const Points& gradient, Points& z) const
{
    graph_.position_factor.solve(gradient, z);
}

Points ArapProblem::positions_for_rotations()
{
    Points x(graph_.free_nodes.size(), 3), gradient;
    for (std::size_t f = 0; f < graph_.free_nodes.size(); ++f)
        for (int k = 0; k < 3; ++k)
            x(f, k) = points_[lanes * static_cast<std::size_t>(graph_.free_nodes[f]) + k];
    for (int k = 0; k < 2; ++k) { // in single precision, each leaves a millionth
        energy_and_gradient(gradient);
        graph_.position_factor.solve(gradient, gradient);
        x -= gradient;
        move_to(x);
    }
    return x;
}

} // namespace sinew
