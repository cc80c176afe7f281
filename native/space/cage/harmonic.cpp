// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/harmonic.h"

#include "native/core/errors.h"
#include "native/space/cage/harmonic_boundary.h"
#include "native/space/cage/harmonic_data.h"
#include "native/space/cage/harmonic_grid.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

/// Where the elements' three to six unknowns a triangle cost a lattice's time and err more than it does.
constexpr int most_triangles = 600;
constexpr int checked_points = 200; ///< for the estimate of the error
constexpr int most_mends = 60;
constexpr double faintest = 1e-12; ///< weight that a vertex cut off has where it is needed

struct Budget
{
    int unknowns; ///< of the elements, at most
    int cells;    ///< of the lattice, along the longest side of the box around the cage
};

Budget budget(HarmonicQuality quality)
{
    switch (quality) {
    case HarmonicQuality::fast:
        return {1000, 96};
    case HarmonicQuality::medium:
        return {2000, 160};
    case HarmonicQuality::fine:
        return {4000, 256};
    default:
        return {12000, 384};
    }
}

int level_for(int triangles, HarmonicQuality quality)
{
    int level = harmonic_pattern_count - 1;
    while (level > 0 && triangles * harmonic_pattern_unknowns(level) > budget(quality).unknowns)
        --level;
    return level;
}

} // namespace

Harmonic::Harmonic(Cage cage, const HarmonicOptions& options)
    : CageCoordinates(std::move(cage), options.weights), quality_(options.quality), solver_(options.solver),
      surface_(this->cage()), outside_(this->cage(), options.outside), data_(harmonic_data(this->cage()))
{
    if (solver_ == HarmonicSolver::automatic)
        solver_ = this->cage().triangles().size() > most_triangles ? HarmonicSolver::lattice
                                                                   : HarmonicSolver::boundary;
}

Harmonic::~Harmonic() = default;

double Harmonic::residual_rms() const { return boundary_ ? boundary_->residual_rms() : 0.0; }
double Harmonic::residual_max() const { return boundary_ ? boundary_->residual_max() : 0.0; }

double Harmonic::prepare(PointsView points, const Progress& progress)
{
    const double share = solver_ == HarmonicSolver::lattice ? 0.9 : 0.6;
    const Progress within([&](double fraction, const char* stage) {
        progress.tick(share * fraction, stage);
        return true;
    });
    if (solver_ == HarmonicSolver::boundary) {
        solve_boundary(points, within);
        return share;
    }
    within.tick(0.0, "cutting the lattice");
    const HarmonicGrid grid(cage(), budget(quality_).cells);
    const int step = static_cast<int>(points.rows()) / checked_points + 1;
    grid_ = std::make_unique<HarmonicGrid::Weights>(grid.evaluate(points, step, within));
    first_point_ = points.data();
    unknowns_ = grid.node_count();
    error_ = grid_->error;
    return share;
}

void Harmonic::solve_boundary(PointsView points, const Progress& progress)
{
    if (!boundary_) {
        const int level = level_for(static_cast<int>(cage().triangles().size()), quality_);
        const auto within = [&](double from, double part) {
            return Progress([&progress, from, part](double fraction, const char* stage) {
                progress.tick(from + part * fraction, stage);
                return true;
            });
        };
        std::unique_ptr<HarmonicBoundary> coarser;
        int half = level;
        while (half >= 0 && 2 * harmonic_pattern_unknowns(half) > harmonic_pattern_unknowns(level))
            --half;
        if (half >= 0)
            coarser = std::make_unique<HarmonicBoundary>(cage(), half, within(0.0, 0.2));
        boundary_ = std::make_unique<HarmonicBoundary>(cage(), level, within(0.2, 0.8));
        coarser_ = std::move(coarser);
        unknowns_ = boundary_->unknowns();
    }

    // A pattern of half the unknowns errs two to three times as much, so the difference is about its error.
    const int step = static_cast<int>(points.rows()) / checked_points + 1;
    Points some((points.rows() + step - 1) / step, 3);
    for (Eigen::Index i = 0; i < some.rows(); ++i)
        some.row(i) = points.row(i * step);
    error_ = boundary_->residual_max();
    if (coarser_) {
        RowMatrix fine, coarse;
        const std::vector<char> inside = evaluate(*boundary_, view(some), fine);
        evaluate(*coarser_, view(some), coarse);
        error_ = 0.0;
        for (Eigen::Index i = 0; i < some.rows(); ++i)
            if (inside[static_cast<std::size_t>(i)])
                error_ = std::max(error_, (fine.row(i) - coarse.row(i)).cwiseAbs().maxCoeff());
    }
}

void Harmonic::evaluate(PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    if (grid_) {
        const auto first = (block.data() - first_point_) / 3;
        rows = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
                   grid_->rows.data() + first * cage().vertex_count(), block.rows(), cage().vertex_count())
                   .cast<double>();
        outside.assign(grid_->inside.begin() + first, grid_->inside.begin() + first + block.rows());
        settle(block, rows, outside);
    } else {
        outside = evaluate(*boundary_, block, rows);
    }
    for (char& flag : outside)
        flag = !flag;
    outside_.fill(block, outside, rows);
}

std::vector<char> Harmonic::evaluate(const HarmonicBoundary& boundary, PointsView block,
                                     RowMatrix& rows) const
{
    std::vector<double> winding;
    boundary.evaluate(block, rows, winding);
    std::vector<char> inside(winding.size());
    for (std::size_t i = 0; i < winding.size(); ++i)
        inside[i] = std::abs(winding[i] - 1.0) < 0.5;
    settle(block, rows, inside);
    return inside;
}

/// Sets the data at points on the cage, which count as inside, and mends the weights of the others there.
void Harmonic::settle(PointsView block, RowMatrix& rows, std::vector<char>& inside) const
{
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        const Vector3 point = block.row(i).transpose();
        char& in = inside[static_cast<std::size_t>(i)];
        Vector3 hats;
        if (const int t = surface_.triangle_at(point, hats); t >= 0) {
            rows.row(i).setZero();
            data_[static_cast<std::size_t>(t)].add(hats, 1.0, rows.row(i).data());
            in = 1;
        } else if (in) {
            mend(point, rows.row(i));
        }
    }
}

void Harmonic::mend(const Vector3& point, Eigen::Ref<Eigen::RowVectorXd> row) const
{
    const Points& vertices = cage().rest().points();
    const auto arm = [&](Eigen::Index v) {
        Eigen::Vector4d homogeneous;
        homogeneous << 1.0, (vertices.row(v).transpose() - point) / cage().size();
        return homogeneous;
    };
    /// The a whose factors 1 + a . arm restore sum and linear precision.
    const auto correction = [&] {
        Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
        for (Eigen::Index v = 0; v < row.size(); ++v)
            if (row[v] > 0.0) {
                const Eigen::Vector4d a = arm(v);
                moments.noalias() += row[v] * a * a.transpose();
            }
        return Eigen::Vector4d(
            moments.partialPivLu().solve(Eigen::Vector4d(Eigen::Vector4d::Unit(0) - moments.col(0))));
    };
    row = row.cwiseMax(0.0);
    Eigen::Vector4d a = correction();
    const Eigen::RowVectorXd before = row;
    double least = a.allFinite() ? 1.0 : 0.0;
    for (Eigen::Index v = 0; v < row.size() && least >= 0.5; ++v)
        if (row[v] > 0.0) {
            const double factor = 1.0 + a.dot(arm(v));
            least = std::min(least, factor);
            row[v] *= factor;
        }
    if (least >= 0.5)
        return;
    // Close to the cage the error may exceed what the far vertices weigh. Factors exp(a . arm), which are
    // Newton's steps to the weights of least relative entropy, reach any point between the vertices.
    row = before.cwiseMax(faintest);
    for (int step = 0; step < most_mends; ++step) {
        a = correction();
        if (!a.allFinite())
            break;
        double largest = 0.0;
        for (Eigen::Index v = 0; v < row.size(); ++v)
            largest = std::max(largest, std::abs(a.dot(arm(v))));
        const double length = std::min(1.0, 2.0 / largest);
        for (Eigen::Index v = 0; v < row.size(); ++v)
            row[v] *= std::exp(length * a.dot(arm(v)));
        if (largest < 1e-12)
            return;
    }
}

void Harmonic::finish(CageReport& report) const { report.error = error_; }

} // namespace sinew
