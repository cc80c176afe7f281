// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/rows/row_problem.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/local_global/arap/cell_fits.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sinew {

namespace {

constexpr int row_grain = 1024, point_grain = 512;

Eigen::Map<Matrix3> at(std::vector<double>& rotations, int group)
{
    return Eigen::Map<Matrix3>(rotations.data() + entries * static_cast<std::size_t>(group));
}

} // namespace

RowProblem::RowProblem(const RowSystem& cells, const RotationVectors& vectors, const Points& held,
                       const Points& pulls, RotationBuffers* buffers)
    : cells_(cells), kernels_(widest_kernels<RowKernels>()), pulls_(pulls),
      own_buffers_(buffers ? nullptr : std::make_unique<RotationBuffers>()),
      buffers_(buffers ? *buffers : *own_buffers_), view_(cells.view())
{
    buffers_.points.resize(3 * static_cast<std::size_t>(cells.point_count()) + 1);
    parallel_for(cells.point_count(), [&](int i) {
        double* const to = buffers_.points.data() + 3 * static_cast<std::size_t>(i);
        for (int axis = 0; axis < 3; ++axis)
            to[axis] = i < cells.free_count() ? vectors.base[3 * static_cast<std::size_t>(i) + axis]
                                              : held(cells.order()[i], axis);
    });
    buffers_.forces.resize(cells.has_four_points() ? 12 * static_cast<std::size_t>(cells.group_count()) + 1
                                                   : 3 * static_cast<std::size_t>(cells.row_count()) + 1);
    buffers_.energies.resize(std::max<std::size_t>(cells.chunks().size(), cells.row_count() / row_grain + 1));
    for (int k = 0; k < (cells.has_pairs() ? 3 : 1); ++k) {
        buffers_.rotations[k].resize(entries * static_cast<std::size_t>(cells.group_count()) + 1);
        parallel_for(cells.group_count(), [&](int g) { at(buffers_.rotations[k], g).setIdentity(); });
    }
    if (cells.has_pairs())
        buffers_.torque.setZero(cells.moving_groups(), 3);
    view_.vectors = vectors.numbers.data();
    view_.base = vectors.base.data();
    view_.points = buffers_.points.data();
}

Matrix3 RowProblem::rotation(int group) const
{
    return at(buffers_.rotations[current_], cells_.inner_group(group));
}

void RowProblem::set_rotation(int group, const Matrix3& R)
{
    for (int k = 0; k < (cells_.has_pairs() ? 3 : 1); ++k)
        at(buffers_.rotations[k], cells_.inner_group(group)) = R;
}

void RowProblem::move_to(const Points& x)
{
    parallel_chunks(cells_.free_count(), 16384, [&](int begin, int end) {
        std::copy(x.data() + 3 * static_cast<std::size_t>(begin),
                  x.data() + 3 * static_cast<std::size_t>(end),
                  buffers_.points.data() + 3 * static_cast<std::size_t>(begin));
    });
}

void RowProblem::place(const Points& x, Points& all)
{
    move_to(x);
    all.resize(cells_.point_count(), 3);
    parallel_for(cells_.point_count(), [&](int i) {
        all.row(cells_.order()[i]) =
            Eigen::Map<const Eigen::RowVector3d>(buffers_.points.data() + 3 * static_cast<std::size_t>(i));
    });
}

RowProblem::Rotations& RowProblem::spare()
{
    int set = 0;
    while (cells_.has_pairs() && (set == kept_ || set == current_))
        ++set;
    return buffers_.rotations[set];
}

/// Twice the energy of the rows of a chunk in a table without pairs, and their forces.
double RowProblem::own_rows(const RowSystem::Chunk& chunk, bool fit)
{
    std::array<double, chunk_numbers> S;
    double* const R = buffers_.rotations[current_].data();
    const bool cells = cells_.has_four_points();
    if (!cells)
        kernels_.stretches(view_, chunk.begin, chunk.end, buffers_.forces.data(), S.data());
    else if (fit)
        kernels_.cell_covariances(view_, chunk.begin, chunk.end, S.data());
    if (fit) {
        double* const own = R + entries * static_cast<std::size_t>(chunk.begin);
        fit_cells(S.data(), own, tie, chunk.end - chunk.begin, own);
    }
    return (cells ? kernels_.cell_forces : kernels_.forces)(view_, chunk.begin, chunk.end, R,
                                                            buffers_.forces.data());
}

void RowProblem::find_residuals()
{
    parallel_chunks(cells_.row_count(), row_grain, [&](int begin, int end) {
        kernels_.residuals(view_, begin, end, buffers_.rotations[current_].data(), buffers_.forces.data());
    });
}

/// Moves the rotations of a table with pairs towards the best ones for the present points.
void RowProblem::settle_pairs()
{
    const std::vector<RowSystem::Chunk>& chunks = cells_.chunks();
    const auto moving = std::ranges::count(chunks, RowSystem::Chunk::moving, &RowSystem::Chunk::kind);
    const auto each = [&](auto&& body) {
        parallel_chunks(static_cast<int>(moving), 1, [&](int c, int) { body(chunks[c]); });
    };
    const ArapKernels& fits = widest_kernels<ArapKernels>();
    for (int sweep = 0; sweep < cells_.options().sweeps; ++sweep) {
        if (cells_.options().field) {
            find_residuals();
            const Rotations& before = buffers_.rotations[current_];
            Points& torque = buffers_.torque;
            each([&](const RowSystem::Chunk& chunk) {
                kernels_.torques(view_, chunk.begin, chunk.end, before.data(), buffers_.forces.data(),
                                 torque.data() + 3 * static_cast<std::size_t>(chunk.begin));
            });
            cells_.rotation_factor().solve(torque, torque);
            Rotations& turned = spare();
            each([&](const RowSystem::Chunk& chunk) {
                const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
                fits.turn(torque.data() + 3 * static_cast<std::size_t>(chunk.begin), before.data() + first,
                          chunk.end - chunk.begin, turned.data() + first);
            });
            current_ = static_cast<int>(&turned - buffers_.rotations);
        }
        find_residuals();
        const Rotations& before = buffers_.rotations[current_];
        Rotations& after = spare();
        each([&](const RowSystem::Chunk& chunk) {
            std::array<double, chunk_numbers> S;
            kernels_.covariances(view_, chunk.begin, chunk.end, before.data(), buffers_.forces.data(),
                                 S.data());
            const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
            fit_cells(S.data(), before.data() + first, 0.0, chunk.end - chunk.begin, after.data() + first);
        });
        current_ = static_cast<int>(&after - buffers_.rotations);
    }
}

/// The energy of all rows, and their forces.
double RowProblem::pass(bool fit)
{
    std::vector<double>& energies = buffers_.energies;
    if (cells_.has_pairs()) {
        if (fit)
            settle_pairs();
        find_residuals();
        parallel_chunks(cells_.row_count(), row_grain, [&](int begin, int end) {
            energies[begin / row_grain] = kernels_.weigh(view_, begin, end, buffers_.forces.data());
        });
        const int parts = (cells_.row_count() + row_grain - 1) / row_grain;
        return 0.5 * std::accumulate(energies.begin(), energies.begin() + parts, 0.0);
    }
    const std::vector<RowSystem::Chunk>& chunks = cells_.chunks();
    const auto run = [&](RowSystem::Chunk::Kind kind, bool fitted) {
        const auto [first, last] = std::ranges::equal_range(chunks, kind, {}, &RowSystem::Chunk::kind);
        const int begin = static_cast<int>(first - chunks.begin());
        parallel_chunks(static_cast<int>(last - first), 1,
                        [&](int c, int) { energies[c] = own_rows(chunks[begin + c], fitted); });
        return 0.5 * std::accumulate(energies.begin(), energies.begin() + (last - first), 0.0);
    };
    if (!fixed_settled_) {
        run(RowSystem::Chunk::fixed, true);
        fixed_energy_ = run(RowSystem::Chunk::fixed, true); // where `tie` has no effect any more
        fixed_settled_ = true;
    }
    return fixed_energy_ + run(RowSystem::Chunk::moving, fit) + run(RowSystem::Chunk::steady, false);
}

double RowProblem::with_pulls(double energy, Points& gradient) const
{
    gradient.resize(cells_.free_count(), 3);
    parallel_chunks(cells_.free_count(), point_grain, [&](int begin, int end) {
        kernels_.gather(view_, begin, end, buffers_.forces.data(), gradient.data());
    });
    for (std::size_t k = 0; k < cells_.pulls().size(); ++k) {
        const auto& [point, stiffness] = cells_.pulls()[k];
        const Eigen::RowVector3d gap = Eigen::Map<const Eigen::RowVector3d>(
                                           buffers_.points.data() + 3 * static_cast<std::size_t>(point)) -
                                       pulls_.row(static_cast<Eigen::Index>(k));
        energy += 0.5 * stiffness * gap.squaredNorm();
        gradient.row(point) += stiffness * gap;
    }
    return energy;
}

double RowProblem::evaluate(const Points& x, Points& gradient)
{
    move_to(x);
    const double energy = pass(true);
    return with_pulls(energy, gradient);
}

void RowProblem::precondition(const Points& gradient, Points& z) const
{
    cells_.position_factor().solve(gradient, z);
}

void RowProblem::global_step(Points& x, int solves)
{
    Points& gradient = buffers_.gradient;
    x = PointsView(buffers_.points.data(), cells_.free_count(), 3);
    for (int k = 0; k < solves; ++k) { // the factor is in single precision, so each leaves a millionth
        with_pulls(pass(false), gradient);
        cells_.position_factor().solve(gradient, gradient);
        x -= gradient;
        move_to(x);
    }
}

} // namespace sinew
