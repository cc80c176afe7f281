// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/problem.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/local_global/arap/cell_fits.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sinew {

namespace {

constexpr double unstrained = 1e-8; ///< energy, as a share of that of a shape shrunk to a point

Eigen::Map<Matrix3> at(std::vector<double>& rotations, int cell)
{
    return Eigen::Map<Matrix3>(rotations.data() + entries * static_cast<std::size_t>(cell));
}

Eigen::Map<Eigen::RowVector3d> at_point(std::vector<double>& points, int point)
{
    return Eigen::Map<Eigen::RowVector3d>(points.data() + 3 * static_cast<std::size_t>(point));
}

} // namespace

PyramidProblem::PyramidProblem(const PyramidCells& cells, const PyramidShape& shape, bool scaled,
                               const Points& places, const Points& pulls, PyramidBuffers& buffers)
    : cells_(cells), kernels_(widest_kernels<PyramidKernels>()), scaled_(scaled), pulls_(pulls),
      buffers_(buffers), view_(cells.view())
{
    const int points = static_cast<int>(cells.order().size());
    buffers_.points.resize(3 * static_cast<std::size_t>(points) + 1);
    parallel_for(points, [&](int p) { at_point(buffers_.points, p) = places.row(cells.order()[p]); });
    buffers_.rotations.resize(entries * static_cast<std::size_t>(cells.cell_count()) + 1);
    parallel_for(cells.cell_count(), [&](int c) { at(buffers_.rotations, c).setIdentity(); });
    buffers_.forces.resize(3 * cells.ends().size() + 1);
    buffers_.sums.resize(3 * static_cast<std::size_t>(cells.cell_count()) + 1);
    buffers_.energies.resize((cells.cell_count() + graph_chunk - 1) / graph_chunk);
    buffers_.sizes.resize(cells.cell_count());
    parallel_for(cells.cell_count(), [&](int c) { buffers_.sizes[c] = cells.size(shape, c); });
    scale_ = std::accumulate(buffers_.sizes.begin(), buffers_.sizes.end(), 0.0);
    view_.edges = shape.edges.data();
    view_.tips = shape.tips.data();
    view_.points = buffers_.points.data();
}

void PyramidProblem::set_rotation(int cell, const Matrix3& R) { at(buffers_.rotations, cell) = R; }

void PyramidProblem::move_to(const Points& x)
{
    parallel_chunks(cells_.moving_count(), 16384, [&](int begin, int end) {
        std::copy(x.data() + 3 * static_cast<std::size_t>(begin),
                  x.data() + 3 * static_cast<std::size_t>(end),
                  buffers_.points.data() + 3 * static_cast<std::size_t>(begin));
    });
}

void PyramidProblem::place(const Points& x, Points& all)
{
    move_to(x);
    all.resize(static_cast<Eigen::Index>(cells_.order().size()), 3);
    parallel_for(static_cast<int>(cells_.order().size()),
                 [&](int p) { all.row(cells_.order()[p]) = at_point(buffers_.points, p); });
}

/// F and its gradient at the present points, with the rotations fitted to them if `fit`.
double PyramidProblem::pass(bool fit, Points& gradient)
{
    parallel_chunks(cells_.cell_count(), graph_chunk, [&](int begin, int end) {
        double* const R = buffers_.rotations.data() + entries * static_cast<std::size_t>(begin);
        if (fit) {
            std::array<double, chunk_numbers> S;
            kernels_.covariances(view_, begin, end, S.data());
            fit_cells(S.data(), R, tie, end - begin, R);
            for (int c = begin; scaled_ && c < end; ++c) {
                Eigen::Map<Matrix3> turn = at(buffers_.rotations, c);
                if (buffers_.sizes[c] > 0)
                    turn *= std::clamp(turn.cwiseProduct(covariance(S.data(), c - begin)).sum() /
                                           buffers_.sizes[c],
                                       least_scale, most_scale);
            }
        }
        buffers_.energies[begin / graph_chunk] = kernels_.forces(
            view_, begin, end, buffers_.rotations.data(), buffers_.forces.data(), buffers_.sums.data());
    });
    double energy = 0.5 * std::accumulate(buffers_.energies.begin(), buffers_.energies.end(), 0.0);
    gradient.resize(cells_.moving_count(), 3);
    parallel_chunks(cells_.moving_count(), 512, [&](int begin, int end) {
        kernels_.gather(view_, begin, end, buffers_.forces.data(), buffers_.sums.data(), gradient.data());
    });
    for (std::size_t k = 0; k < cells_.pulls().size(); ++k) {
        const auto& [point, stiffness] = cells_.pulls()[k];
        const Eigen::RowVector3d gap =
            at_point(buffers_.points, point) - pulls_.row(static_cast<Eigen::Index>(k));
        energy += 0.5 * stiffness * gap.squaredNorm();
        gradient.row(point) += stiffness * gap;
    }
    return energy;
}

double PyramidProblem::evaluate(const Points& x, Points& gradient)
{
    move_to(x);
    return pass(true, gradient);
}

void PyramidProblem::precondition(const Points& gradient, Points& z) const
{
    cells_.factor().solve(gradient, z);
}

void PyramidProblem::global_step(Points& x)
{
    x = PointsView(buffers_.points.data(), cells_.moving_count(), 3);
    // The factor is in single precision, so each solve leaves a share of the error. That counts where hardly
    // anything is strained; elsewhere the descent goes on from here anyway.
    for (int k = 0; k < 3; ++k) {
        if (pass(false, buffers_.gradient) > unstrained * scale_ && k > 1)
            break;
        cells_.factor().solve(buffers_.gradient, buffers_.gradient);
        x -= buffers_.gradient;
        move_to(x);
    }
}

} // namespace sinew
