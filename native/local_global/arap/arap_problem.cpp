// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_problem.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/local_global/arap/cell_fits.h"
#include "native/local_global/graph/rotations.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

/// The share of a motion that is taken: bent sheets are stiffer than the rest, whose metric it is found in.
constexpr double usual_share = 0.8;
constexpr int most_trials = 3;
/// A share of sum w |p_i - p_j|^2: with less energy, the rounding of a solve in single precision would show.
constexpr double nearly_rigid = 1e-9;
/// What iterations may leave of a step, and of the first solve for the positions: an estimate before the last cycle.
constexpr double step_error = 0.1, start_error = 1e-4;

} // namespace

ArapProblem::ArapProblem(const ArapSystem& graph, const PointsView& base, const Points& targets,
                         const Points& pulls, ArapBuffers* buffers)
    : graph_(graph), kernels_(widest_kernels<ArapKernels>()), pulls_(pulls),
      own_buffers_(buffers ? nullptr : std::make_unique<ArapBuffers>()),
      buffers_(buffers ? *buffers : *own_buffers_)
{
    buffers_.energies.resize(graph.chunks().all.size());
    pack(base, buffers_.base);
    pack(view(targets), buffers_.points);
    std::copy_n(buffers_.base.data(), 3 * static_cast<std::size_t>(graph.free_count()),
                buffers_.points.data());
    view_ = {.edges = graph.chunks().edges.data(),
             .ends = graph.chunks().ends.data(),
             .weights = graph.chunks().weights.data(),
             .triangles = graph.chunks().triangles.data(),
             .rims = graph.cells().rims,
             .rigidity = graph.cells().rigidity.data(),
             .free = graph.free_count(),
             .base = buffers_.base.data(),
             .points = buffers_.points.data(),
             .smoothing = graph.cells().smoothing};
    const int present = graph.chunks().present();
    for (int k = 0; k < (graph.is_smooth() ? 3 : 1); ++k) {
        Matrices& rotations = buffers_.rotations[k];
        rotations.resize(entries * static_cast<std::size_t>(graph.size()) + 1);
        const int first = k == 0 ? 0 : present; // no evaluation writes those of idle nodes in any of the sets
        parallel_for(graph.size() - first, [&](int i) {
            Eigen::Map<Matrix3>(rotations.data() + entries * static_cast<std::size_t>(first + i))
                .setIdentity();
        });
    }
}

/// Fits the rotations of the cells that depend on no free node, and computes their energy; only the first
/// call does.
void ArapProblem::fit_fixed_cells()
{
    if (fixed_cells_fitted_)
        return;
    fixed_cells_fitted_ = true;
    const int count = static_cast<int>(graph_.chunks().all.size()) - graph_.chunks().moving;
    parallel_chunks(count, 1, [&](int c, int) {
        const GraphChunk& chunk = graph_.chunks().all[graph_.chunks().moving + c];
        std::array<double, chunk_numbers> S;
        kernels_.covariances(view_, chunk, S.data());
        for (int k = 0; k < 2; ++k) // the second fit starts at the minimum, where `tie` has no effect
            fit(chunk, S.data(), buffers_.rotations[current_], tie, buffers_.rotations[current_]);
    });
    parallel_chunks(count, 1, [&](int c, int) {
        const GraphChunk& chunk = graph_.chunks().all[graph_.chunks().moving + c];
        buffers_.energies[c] = kernels_.energy(view_, chunk, buffers_.rotations[current_].data(), nullptr);
    });
    energy_of_fixed_cells_ =
        std::accumulate(buffers_.energies.begin(), buffers_.energies.begin() + count, 0.0);
}

Matrix3 ArapProblem::rotation(int i) const
{
    return Eigen::Map<const Matrix3>(buffers_.rotations[current_].data() +
                                     entries * static_cast<std::size_t>(i));
}

void ArapProblem::set_rotation(int i, const Matrix3& R)
{
    Eigen::Map<Matrix3>(buffers_.rotations[current_].data() + entries * static_cast<std::size_t>(i)) = R;
}

void ArapProblem::move_to(const Points& x)
{
    parallel_chunks(graph_.free_count(), 16384, [&](int begin, int end) {
        std::copy(x.data() + 3 * static_cast<std::size_t>(begin),
                  x.data() + 3 * static_cast<std::size_t>(end),
                  buffers_.points.data() + 3 * static_cast<std::size_t>(begin));
    });
}

PointsView ArapProblem::place(const Points& x)
{
    move_to(x);
    return PointsView(buffers_.points.data(), graph_.size(), 3);
}

int ArapProblem::spare(int used) const
{
    int set = 0;
    while (set == kept_ || set == used)
        ++set;
    return set;
}

void ArapProblem::for_each_moving(const std::function<void(const GraphChunk&)>& body) const
{
    parallel_chunks(graph_.chunks().moving, 1, [&](int c, int) { body(graph_.chunks().all[c]); });
}

void ArapProblem::fit(const GraphChunk& chunk, const double* S, const Matrices& before, double tie,
                      Matrices& after) const
{
    const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
    fit_cells(S, before.data() + first, tie, chunk.end - chunk.begin, after.data() + first);
}

double* ArapProblem::covariances_of(const GraphChunk& chunk) const
{
    return buffers_.covariances.data() + (&chunk - graph_.chunks().all.data()) * chunk_numbers;
}

/// One linearised step of all rotations together: (moment + 4 alpha A L) omega = torque. By fits of single
/// cells alone, a rotation would spread by only one ring per iteration.
void ArapProblem::turn_rotation_field()
{
    const Matrices& before = buffers_.rotations[current_];
    Points& torque = buffers_.torque;
    if (torque.rows() != graph_.size())
        torque.setZero(graph_.size(), 3); // the kernels leave that of idle nodes at zero
    for_each_moving([&](const GraphChunk& chunk) {
        double* const S = covariances_of(chunk);
        kernels_.covariances(view_, chunk, S);
        kernels_.torques(view_, chunk, S, before.data(),
                         torque.data() + 3 * static_cast<std::size_t>(chunk.begin));
    });
    graph_.solve_rotations(torque, torque, step_error, *progress_);
    const int turned = current_ == kept_ ? spare(current_) : current_;
    for_each_moving([&](const GraphChunk& chunk) {
        const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
        kernels_.turn(torque.data() + 3 * static_cast<std::size_t>(chunk.begin), before.data() + first,
                      chunk.end - chunk.begin, buffers_.rotations[turned].data() + first);
    });
    current_ = turned;
}

void ArapProblem::local_step(const Points& x)
{
    move_to(x);
    fit_fixed_cells();
    stale_ = false;
    const Matrices& before = buffers_.rotations[current_];
    const int next = current_ == kept_ ? spare(current_) : current_;
    for_each_moving([&](const GraphChunk& chunk) {
        std::array<double, chunk_numbers> S;
        kernels_.covariances(view_, chunk, S.data());
        fit(chunk, S.data(), before, tie, buffers_.rotations[next]);
    });
    current_ = next;
}

double ArapProblem::energy_and_gradient(Points& gradient) const
{
    gradient.resize(graph_.free_count(), 3);
    std::vector<double>& energies = buffers_.energies;
    parallel_chunks(graph_.chunks().moving, 1, [&](int c, int) {
        energies[c] = kernels_.energy(view_, graph_.chunks().all[c], buffers_.rotations[current_].data(),
                                      gradient.data());
    });
    double energy =
        std::accumulate(energies.begin(), energies.begin() + graph_.chunks().moving, energy_of_fixed_cells_) /
        graph_.energy_factor();

    for (std::size_t k = 0; k < graph_.nodes().pulls().size(); ++k) {
        const GraphPull& pull = graph_.nodes().pulls()[k];
        const Eigen::Map<const Eigen::RowVector3d> at(buffers_.points.data() +
                                                      3 * static_cast<std::size_t>(pull.node));
        const Eigen::RowVector3d gap = at - pulls_.row(k);
        energy += 0.5 * pull.stiffness * gap.squaredNorm();
        gradient.row(pull.node) += pull.stiffness * gap;
    }
    return energy;
}

double ArapProblem::evaluate(const Points& x, Points& gradient)
{
    if (graph_.is_smooth()) {
        move_to(x);
        fit_fixed_cells();
        buffers_.covariances.resize(graph_.chunks().moving * chunk_numbers);
        turn_rotation_field();
        const Matrices& before = buffers_.rotations[current_];
        const int next = spare(current_);
        for_each_moving([&](const GraphChunk& chunk) {
            std::array<double, chunk_numbers> S;
            std::copy_n(covariances_of(chunk), covariance_columns * (chunk.end - chunk.begin), S.data());
            kernels_.add_neighbours(view_, chunk, before.data(), S.data());
            fit(chunk, S.data(), before, 0.0, buffers_.rotations[next]);
        });
        current_ = next;
    } else {
        local_step(x);
    }
    return energy_and_gradient(gradient);
}

void ArapProblem::precondition(const Points& gradient, Points& z) const
{
    graph_.solve_positions(gradient, z, step_error, *progress_);
}

bool ArapProblem::improve(Points& x, Points& gradient, double& F)
{
    if (!motions_ || motions_->empty())
        return false;
    const bool smooth = graph_.is_smooth();
    ClusterMotions::Motion& motion = buffers_.motion;
    Points &better = buffers_.better, &torque = buffers_.torque;
    const Points none;
    if (smooth)
        for_each_moving([&](const GraphChunk& chunk) {
            kernels_.torques(view_, chunk, covariances_of(chunk), buffers_.rotations[current_].data(),
                             torque.data() + 3 * static_cast<std::size_t>(chunk.begin));
        });
    const double slope =
        motions_->solve(x, buffers_.points.data(), buffers_.rotations[current_].data(), gradient,
                        smooth ? torque : none, 2.0 / graph_.energy_factor(), motion);
    const int before = current_;
    better.resize(x.rows(), 3);
    double share = usual_share;
    for (int k = 0; k < most_trials; ++k) {
        motions_->scale(share, motion);
        torque.resize(graph_.size(), 3);
        parallel_for(graph_.size(), [&](int i) {
            Eigen::RowVector3d to, turn = Eigen::RowVector3d::Zero();
            if (i < graph_.free_count()) {
                motions_->move(motion, i, x.row(i), to, turn);
                better.row(i) = to;
            }
            torque.row(i) = turn;
        });
        const double F_better = try_better(before);
        if (F_better < F)
            return accept(F_better, x, gradient, F);
        const double parabola = slope * share * share / (2 * (F_better - F + slope * share));
        share = std::clamp(parabola, 0.1 * share, 0.6 * share);
    }
    return_to(before, x);
    return false;
}

bool ArapProblem::go_on(const Points& from, double F_from, double share, Points& x, Points& gradient,
                        double& F)
{
    Points &better = buffers_.better, &torque = buffers_.torque;
    const int before = current_;
    better.resize(x.rows(), 3);
    parallel_for(x.rows(), [&](int i) { better.row(i) = x.row(i) + share * (x.row(i) - from.row(i)); });
    if (graph_.is_smooth())
        for_each_moving([&](const GraphChunk& chunk) {
            for (int i = chunk.begin; i < chunk.end; ++i) {
                const std::size_t at = entries * static_cast<std::size_t>(i);
                const Eigen::Map<const Matrix3> now(buffers_.rotations[before].data() + at),
                    then(buffers_.rotations[kept_].data() + at);
                const Matrix3 turn = now * then.transpose();
                torque.row(i) = 0.5 * share *
                                Eigen::RowVector3d(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0),
                                                   turn(1, 0) - turn(0, 1));
            }
        });
    if (const double F_better = try_better(before); F_better < F_from)
        return accept(F_better, x, gradient, F);
    return_to(before, x);
    return false;
}

double ArapProblem::try_better(int before)
{
    if (!graph_.is_smooth())
        return evaluate(buffers_.better, buffers_.better_gradient);
    const int next = spare(before);
    for_each_moving([&](const GraphChunk& chunk) {
        const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
        kernels_.turn(buffers_.torque.data() + 3 * static_cast<std::size_t>(chunk.begin),
                      buffers_.rotations[before].data() + first, chunk.end - chunk.begin,
                      buffers_.rotations[next].data() + first);
    });
    current_ = next;
    move_to(buffers_.better);
    return energy_and_gradient(buffers_.better_gradient);
}

bool ArapProblem::accept(double F_better, Points& x, Points& gradient, double& F)
{
    F = F_better;
    x.swap(buffers_.better);
    gradient.swap(buffers_.better_gradient);
    return true;
}

void ArapProblem::return_to(int before, const Points& x)
{
    current_ = before;
    stale_ = !graph_.is_smooth();
    move_to(x);
}

void ArapProblem::global_step(Points& x)
{
    Points& gradient = buffers_.gradient;
    x = PointsView(buffers_.points.data(), graph_.free_count(), 3);
    for (int k = 0; k < 2; ++k) {
        const double F = energy_and_gradient(gradient);
        if (k > 0 && F > nearly_rigid * graph_.rest_scale())
            break; // the next step takes what the first solve has left
        graph_.solve_positions(gradient, gradient, start_error, *progress_);
        x -= gradient;
        move_to(x);
    }
}

} // namespace sinew
