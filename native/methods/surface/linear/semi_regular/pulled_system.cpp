// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/pulled_system.h"

#include "native/core/parallel.h"
#include "native/operators/laplacian.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace sinew {

void PulledSystem::factorize(const SparseMatrix& A, const SparseRows& S, std::vector<double> stiffness,
                             const std::vector<bool>& free)
{
    SparseMatrix pulls = S;
    const Eigen::Map<const VectorX> s(stiffness.data(), static_cast<Eigen::Index>(stiffness.size()));
    auto sum = std::make_shared<SparseMatrix>(A);
    if (S.rows() > 0) {
        const SparseMatrix weighted = s.asDiagonal() * pulls;
        *sum += SparseMatrix(SparseMatrix(pulls.transpose()) * weighted);
    }
    sum->makeCompressed();
    equations_.factorize(std::move(sum), free);
    stiffness_ = std::move(stiffness);
    pulls_.swap(pulls);
}

SolveReport PulledSystem::solve(RowMatrix& u, const Points& pulled, Workspace& work) const
{
    const int n = static_cast<int>(u.rows());
    work.b.resize(n, 3);
    parallel_for(n, [&](int j) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (SparseMatrix::InnerIterator it(pulls_, j); it; ++it)
            sum += it.value() * stiffness_[it.row()] * pulled.row(it.row());
        work.b.row(j) = sum;
    });
    equations_.solve(u, &work.b, work.equations);
    const ConstrainedQuadratic::Norms norms = equations_.norms(u, &work.b);
    double energy = norms.energy - 2 * parallel_sum(n, [&](int j) { return u.row(j).dot(work.b.row(j)); });
    for (std::size_t i = 0; i < stiffness_.size(); ++i)
        energy += stiffness_[i] * pulled.row(static_cast<Eigen::Index>(i)).squaredNorm();
    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.energy = std::max(0.0, 0.5 * energy); // rounding may take it below
    report.residual = norms.load > 0 ? std::sqrt(norms.residual / norms.load) : 0.0;
    return report;
}

SparseMatrix plate_energy(const SurfaceMesh& mesh)
{
    const TriangleMetric metric = triangle_metric(mesh, least_area_for_order(2));
    const SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan_voronoi, metric);
    return sparse_product(L, divisible_mass(mesh, Discretization::cotan_voronoi, metric).cwiseInverse(), L);
}

} // namespace sinew
