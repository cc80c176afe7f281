// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic.h"

#include "native/core/errors.h"
#include "native/core/progress_part.h"
#include "native/methods/space/cage/harmonic/boundary.h"
#include "native/methods/space/cage/harmonic/data.h"
#include "native/methods/space/cage/harmonic/grid.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace sinew {

namespace {

/// For more triangles, boundary elements with their three to six unknowns per triangle take as long as a
/// lattice and are less accurate.
constexpr int most_triangles = 600;
constexpr int checked_points = 200; ///< number of points for the estimate of the error
constexpr int most_newton_steps = 60;
constexpr double least_weight = 1e-12; ///< the least weight of a vertex before correct_near_cage()

struct Budget
{
    int unknowns; ///< largest number of unknowns of the boundary elements
    int cells;    ///< cells of the lattice along the longest side of the box around the cage
};

Budget budget(HarmonicQuality quality)
{
    switch (quality) {
    case HarmonicQuality::fast:
        return {1000, 96};
    case HarmonicQuality::medium:
        return {2000, 160};
    case HarmonicQuality::fine:
        return {4100, 256};
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
    : CageCoordinates(std::move(cage), options.weights), options_(options), solver_(options.solver),
      surface_(this->cage()), outside_(this->cage(), options.outside), data_(harmonic_data(this->cage()))
{
    if (solver_ == HarmonicSolver::automatic)
        solver_ = this->cage().triangles().size() > most_triangles ? HarmonicSolver::lattice
                                                                   : HarmonicSolver::boundary;
    const Points& vertices = this->cage().control();
    middle_ = vertices.colwise().mean().transpose();
    places_.resize(4, vertices.rows());
    places_.row(0).setOnes();
    places_.bottomRows(3) = (vertices.rowwise() - middle_.transpose()).transpose() / this->cage().size();
    products_.resize(vertices.rows(), 10);
    for (int i = 0, column = 0; i < 4; ++i)
        for (int j = i; j < 4; ++j)
            products_.col(column++) = places_.row(i).cwiseProduct(places_.row(j)).transpose();
}

Harmonic::~Harmonic() = default;

double Harmonic::residual_rms() const { return boundary_ ? boundary_->residual_rms() : 0.0; }
double Harmonic::residual_max() const { return boundary_ ? boundary_->residual_max() : 0.0; }

std::vector<std::string> Harmonic::changed_settings(const SpaceMethod& former) const
{
    return changed(options_, static_cast<const Harmonic&>(former).options_,
                   CageCoordinates::changed_settings(former));
}

void Harmonic::swap_weights(SpaceMethod& other)
{
    CageCoordinates::swap_weights(other);
    auto& others = static_cast<Harmonic&>(other);
    std::swap(boundary_, others.boundary_);
    std::swap(coarser_, others.coarser_);
    std::swap(unknowns_, others.unknowns_);
    std::swap(error_, others.error_);
}

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
    const HarmonicGrid grid(cage(), budget(options_.quality).cells);
    const int step = static_cast<int>(points.rows()) / checked_points + 1;
    grid_ = std::make_unique<HarmonicGrid::Weights>(grid.evaluate(points, step, within));
    unknowns_ = grid.node_count();
    error_ = grid_->error;
    return share;
}

void Harmonic::solve_boundary(PointsView points, const Progress& progress)
{
    if (!boundary_) {
        const int level = level_for(static_cast<int>(cage().triangles().size()), options_.quality);
        std::unique_ptr<HarmonicBoundary> coarser;
        int half = level;
        while (half >= 0 && 2 * harmonic_pattern_unknowns(half) > harmonic_pattern_unknowns(level))
            --half;
        if (half >= 0)
            coarser = std::make_unique<HarmonicBoundary>(cage(), half, part_of(progress, 0.0, 0.2));
        boundary_ = std::make_unique<HarmonicBoundary>(cage(), level, part_of(progress, 0.2, 1.0));
        coarser_ = std::move(coarser);
        unknowns_ = boundary_->unknowns();
    }

    // The error of a pattern with half the unknowns is two to three times as large. So the difference between
    // the two is about as large as the error of the finer one, or larger.
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

void Harmonic::evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    if (grid_) {
        rows = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
                   grid_->rows.data() + static_cast<std::ptrdiff_t>(first) * cage().control_count(),
                   block.rows(), cage().control_count())
                   .cast<double>();
        outside.assign(grid_->inside.begin() + first, grid_->inside.begin() + first + block.rows());
        complete(block, rows, outside);
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
    complete(block, rows, inside);
    return inside;
}

/// Sets the rows of points on the cage, which count as inside, to the data, and corrects those of other
/// points inside.
void Harmonic::complete(PointsView block, RowMatrix& rows, std::vector<char>& inside) const
{
    std::vector<int> within;
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        char& in = inside[static_cast<std::size_t>(i)];
        Vector3 hats;
        if (const int t = surface_.triangle_at(block.row(i).transpose(), hats); t >= 0) {
            rows.row(i).setZero();
            data_[static_cast<std::size_t>(t)].add(hats, 1.0, rows.row(i).data());
            in = 1;
        } else if (in) {
            within.push_back(static_cast<int>(i));
        }
    }
    correct(block, within, rows);
}

/// Sets negative weights to 0. With z = (1, v - x), factors 1 + a . z, where a solves (sum w z z^T) a = e -
/// sum w z, restore the sum and linear precision. One matrix product gives the moments of all points.
void Harmonic::correct(PointsView block, const std::vector<int>& inside, RowMatrix& rows) const
{
    RowMatrix weights(static_cast<Eigen::Index>(inside.size()), rows.cols());
    for (std::size_t k = 0; k < inside.size(); ++k)
        weights.row(static_cast<Eigen::Index>(k)) = rows.row(inside[k]).cwiseMax(0.0);
    const RowMatrix moments = weights * products_;
    RowMatrix changes(weights.rows(), 4);
    for (Eigen::Index k = 0; k < weights.rows(); ++k) {
        Eigen::Matrix4d about_middle;
        for (int i = 0, column = 0; i < 4; ++i)
            for (int j = i; j < 4; ++j)
                about_middle(i, j) = about_middle(j, i) = moments(k, column++);
        Eigen::Matrix4d shift = Eigen::Matrix4d::Identity(); // takes moments about the middle to the point
        shift.col(0).tail<3>() =
            (middle_ - block.row(inside[static_cast<std::size_t>(k)]).transpose()) / cage().size();
        const Eigen::Matrix4d about_point = shift * about_middle * shift.transpose();
        const Eigen::Vector4d a =
            about_point.partialPivLu().solve(Eigen::Vector4d(Eigen::Vector4d::Unit(0) - about_point.col(0)));
        changes.row(k) = (shift.transpose() * a).transpose();
    }
    const RowMatrix factors = changes * places_;
    for (std::size_t k = 0; k < inside.size(); ++k) {
        const auto kept = weights.row(static_cast<Eigen::Index>(k));
        const auto by = factors.row(static_cast<Eigen::Index>(k)).array();
        // A weight of 0 stays 0 with any factor.
        const bool gentle = ((kept.array() <= 0.0) || (by >= -0.5)).all();
        auto row = rows.row(inside[k]);
        row = kept;
        if (gentle)
            row.array() *= 1.0 + by;
        else
            correct_near_cage(block.row(inside[k]).transpose(), row);
    }
}

/// Close to the cage, the error may be larger than the weights of far vertices, so that factors 1 + a . z
/// would be negative. Factors exp(a . z) are positive and can reach any point between the vertices. They are
/// steps of Newton's method to the weights of least relative entropy.
void Harmonic::correct_near_cage(const Vector3& point, Eigen::Ref<Eigen::RowVectorXd> row) const
{
    const Points& vertices = cage().control();
    const auto arm = [&](Eigen::Index v) {
        Eigen::Vector4d homogeneous;
        homogeneous << 1.0, (vertices.row(v).transpose() - point) / cage().size();
        return homogeneous;
    };
    row = row.cwiseMax(least_weight);
    for (int step = 0; step < most_newton_steps; ++step) {
        Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
        for (Eigen::Index v = 0; v < row.size(); ++v) {
            const Eigen::Vector4d z = arm(v);
            moments.noalias() += row[v] * z * z.transpose();
        }
        const Eigen::Vector4d a =
            moments.partialPivLu().solve(Eigen::Vector4d(Eigen::Vector4d::Unit(0) - moments.col(0)));
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

void Harmonic::finish(SpaceReport& report) const { report.error = error_; }

} // namespace sinew
