// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/reduced/subspace_cells.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double anchor_share = 1e-5; ///< e, as a share of the mean diagonal
constexpr double volume_tolerance = 1e-5; ///< of the coarse volume, while iterating
constexpr int most_admissions = 4;

/// Minus the weights of L below its diagonal and above it.
template <class Visit>
void each_neighbour(const SparseMatrix& L, int vertex, Visit&& visit)
{
    for (SparseMatrix::InnerIterator it(L, vertex); it; ++it)
        if (it.row() != vertex)
            visit(static_cast<int>(it.row()), -it.value());
}

/// W of a cluster.
/// \param LB  (n, c) L B
MatrixX stiffness_of(const std::vector<int>& members, const RowMatrix& B, const RowMatrix& LB,
                     const SparseMatrix& L, const VectorX& mass, double curvature)
{
    std::vector<int> ring = members;
    for (const int i : members)
        each_neighbour(L, i, [&](int j, double) { ring.push_back(j); });
    std::ranges::sort(ring);
    ring.erase(std::ranges::unique(ring).begin(), ring.end());
    const auto place = [&](int v) { return std::ranges::lower_bound(ring, v) - ring.begin(); };
    RowMatrix around = B(ring, Eigen::all), forces = RowMatrix::Zero(around.rows(), around.cols());
    for (const int i : members) {
        const Eigen::Index own = place(i);
        each_neighbour(L, i, [&](int j, double weight) {
            const Eigen::Index other = place(j);
            const VectorX half = 0.5 * weight * (B.row(i) - B.row(j));
            forces.row(own) += half.transpose();
            forces.row(other) -= half.transpose();
        });
    }
    MatrixX W = transposed_product(around, forces);
    RowMatrix curved = LB(members, Eigen::all), weighted = curved;
    for (std::size_t k = 0; k < members.size(); ++k)
        weighted.row(static_cast<Eigen::Index>(k)) *= curvature / mass[members[k]];
    W += transposed_product(curved, weighted);
    return 0.5 * (W + W.transpose());
}

} // namespace

SubspaceCells::SubspaceCells(const RowMatrix& B, const SparseMatrix& L, const VectorX& mass,
                             const std::vector<int>& labels, int clusters, double curvature,
                             const std::vector<Pull>& pulls, int handles)
    : stiffness_(clusters), pulls_(handles)
{
    std::vector<std::vector<int>> members(clusters);
    for (std::size_t v = 0; v < labels.size(); ++v)
        members[labels[v]].push_back(static_cast<int>(v));
    RowMatrix LB = RowMatrix::Zero(B.rows(), B.cols());
    parallel_for(static_cast<int>(B.rows()), [&](int i) {
        each_neighbour(L, i, [&](int j, double weight) { LB.row(i) += weight * (B.row(i) - B.row(j)); });
    });
    parallel_tasks(clusters,
                   [&](int k) { stiffness_[k] = stiffness_of(members[k], B, LB, L, mass, curvature); });
    std::vector<std::vector<Pull>> by_handle(handles);
    for (const Pull& pull : pulls)
        by_handle[pull.handle].push_back(pull);
    parallel_tasks(handles, [&](int h) {
        RowMatrix rows(static_cast<Eigen::Index>(by_handle[h].size()), B.cols());
        for (std::size_t k = 0; k < by_handle[h].size(); ++k)
            rows.row(static_cast<Eigen::Index>(k)) =
                std::sqrt(by_handle[h][k].stiffness) * B.row(by_handle[h][k].vertex);
        pulls_[h] = transposed_product(rows, rows);
    });
    A_ = MatrixX::Zero(B.cols(), B.cols());
    for (const auto* const matrices : {&stiffness_, &pulls_})
        for (const MatrixX& each : *matrices)
            A_ += each;
    MatrixX own = MatrixX::Zero(A_.rows(), A_.cols());
    for (const MatrixX& each : stiffness_)
        own += each;
    anchor_ = anchor_share * std::max(own.diagonal().mean(), 1e-12 * A_.diagonal().mean());
    A_.diagonal().array() += anchor_;
    if (!factor_.factorize(A_) || !A_.allFinite() || !(anchor_ > 0))
        throw FactorizationFailed("the surface has no area, so its shape has no energy");
}

std::int64_t SubspaceCells::bytes() const
{
    const auto size = static_cast<std::int64_t>(A_.size() * sizeof(double));
    return size * static_cast<std::int64_t>(stiffness_.size() + pulls_.size() + 2);
}

SubspaceCells::Base SubspaceCells::base(const Points& y) const
{
    Base base{y, MatrixX(y.rows(), 3 * cluster_count()), Rows(3 * cluster_count(), 3)};
    for (int k = 0; k < cluster_count(); ++k) {
        base.z.middleCols<3>(3 * k) = stiffness_[k] * y;
        const Matrix3 own = y.transpose() * base.z.middleCols<3>(3 * k);
        base.own.middleRows<3>(3 * k) = 0.5 * (own + own.transpose());
    }
    return base;
}

SubspaceProblem::SubspaceProblem(const SubspaceCells& cells, const SubspaceCells::Base& base,
                                 const Pose& mean, const std::vector<Points>& targets,
                                 const CoarseVolume* coarse, const Points& shape)
    : cells_(cells), base_(base), coarse_(coarse), shape_(shape), mean_(mean.leftCols<3>().transpose()),
      forces_(Points::Zero(base.y.rows(), 3))
{
    for (std::size_t h = 0; h < targets.size(); ++h) {
        const Points force = cells.pulls_[h] * targets[h];
        constant_ += targets[h].cwiseProduct(force).sum();
        forces_ += force;
    }
    const Eigen::Index rows = 3 * static_cast<Eigen::Index>(padded(cells.cluster_count()));
    rotations_ = SubspaceCells::Rows::Zero(rows, 3);
    fits_ = rotations_;
    turns_ = SubspaceCells::Rows::Zero(base.own.rows(), 3);
    for (int k = 0; k < cells.cluster_count(); ++k)
        rotations_.middleRows<3>(3 * k) = mean_;
    fixed_ = base.own * mean_;
    if (coarse_)
        wanted_ = coarse_->volume.of(view(shape_));
}

void SubspaceProblem::set_rotation(int cluster, const Matrix3& R)
{
    rotations_.middleRows<3>(3 * cluster) = R.transpose();
    turns_.middleRows<3>(3 * cluster) = R.transpose() - mean_;
}

Points SubspaceProblem::unknowns_for_rotations()
{
    Points u = cells_.factor_.solve(Points(base_.z * turns_ + forces_));
    admit(u);
    return u;
}

double SubspaceProblem::evaluate(const Points& u, Points& gradient)
{
    const Eigen::Index rows = fixed_.rows();
    fits_.topRows(rows).noalias() = base_.z.transpose() * u;
    fits_.topRows(rows) += fixed_;
    fit_clusters(fits_, rotations_, cells_.cluster_count(), rotations_);
    double twice = constant_;
    for (int k = 0; k < cells_.cluster_count(); ++k) {
        auto turn = turns_.middleRows<3>(3 * k);
        turn = rotations_.middleRows<3>(3 * k) - mean_;
        twice += turn.cwiseProduct(base_.own.middleRows<3>(3 * k) * turn).sum();
    }
    const Points forces = base_.z * turns_ + forces_;
    gradient.noalias() = cells_.A_ * u;
    twice += u.cwiseProduct(gradient - 2 * forces).sum();
    gradient -= forces;
    if (normal_.size() > 0)
        if (const double square = normal_.cwiseProduct(direction_).sum(); square > 0)
            gradient -= direction_.cwiseProduct(gradient).sum() / square * normal_;
    return std::max(0.0, 0.5 * twice);
}

void SubspaceProblem::precondition(const Points& gradient, Points& z) const
{
    z = cells_.factor_.solve(gradient);
}

/// Computes the volume at u and its gradient.
double SubspaceProblem::measure(const Points& u)
{
    coarse_points_.noalias() = coarse_->B * u;
    coarse_points_ += shape_;
    const double volume = coarse_->volume.gradient(view(coarse_points_), coarse_gradient_);
    normal_.noalias() = coarse_->B.transpose() * coarse_gradient_;
    direction_ = cells_.factor_.solve(normal_);
    return volume;
}

bool SubspaceProblem::admit(Points& u)
{
    if (!coarse_)
        return false;
    bool moved = false;
    for (int k = 0; k < most_admissions; ++k) {
        const double missing = wanted_ - measure(u), square = normal_.cwiseProduct(direction_).sum();
        if (std::abs(missing) <= volume_tolerance * std::abs(wanted_) || !(square > 0))
            break;
        u += missing / square * direction_;
        moved = true;
    }
    return moved;
}

} // namespace sinew
