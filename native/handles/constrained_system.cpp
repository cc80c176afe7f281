// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/constrained_system.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/handles/system_solver.h"
#include "native/solvers/solved_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

/// The stiffnesses of the soft pulls.
std::vector<double> pulls_of(const Regions& regions, const VectorX& diagonal)
{
    std::vector<double> stiffness;
    const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
    for (const SoftConstraint& s : regions.soft())
        stiffness.push_back(s.stiffness() * (diagonal[s.vertex] > 0 ? diagonal[s.vertex] : mean));
    return stiffness;
}

/// Adds the soft pulls to the diagonal of A, and returns their stiffnesses.
std::vector<double> add_pulls(const Regions& regions, SparseMatrix& A)
{
    if (regions.soft().empty())
        return {};
    std::vector<double> stiffness = pulls_of(regions, A.diagonal());
    for (std::size_t k = 0; k < stiffness.size(); ++k) {
        const int v = regions.soft()[k].vertex;
        A.coeffRef(v, v) += stiffness[k];
    }
    A.makeCompressed();
    return stiffness;
}

/// The diagonal of A, which follows from the graph.
VectorX diagonal_of(const LinearSystem& system)
{
    const SparseMatrix& L = system.graph;
    VectorX diagonal = L.diagonal();
    if (system.order == 2)
        parallel_for(static_cast<int>(L.cols()), [&](int i) {
            double sum = system.membrane * diagonal[i];
            for (SparseMatrix::InnerIterator it(L, i); it; ++it)
                sum += it.value() * it.value() / system.mass[it.row()];
            diagonal[i] = sum;
        });
    return diagonal;
}

} // namespace

void ConstrainedSystem::factorize(std::shared_ptr<SparseMatrix> A, const Regions& regions,
                                  const std::function<void()>& completed, const Regions* wider)
{
    std::vector<double> stiffness = add_pulls(regions, *A);
    const std::vector<bool> free = regions.free_vertices(),
                            more = wider ? wider->free_vertices() : std::vector<bool>{};
    exchange(regions, std::move(stiffness), nullptr, [&] {
        const ConstrainedQuadratic::Problem before = equations_.problem();
        try {
            equations_.factorize(std::move(A), free, more);
            if (completed)
                completed();
        } catch (const std::exception&) {
            equations_.restore(before);
            throw;
        }
    });
    ++factorizations_;
}

void ConstrainedSystem::iterate(LinearSystem system, const Regions& regions, const Progress& progress,
                                const std::function<void()>& completed)
{
    std::vector<double> stiffness;
    if (!regions.soft().empty())
        stiffness = pulls_of(regions, diagonal_of(system));
    VectorX pulls = VectorX::Zero(regions.vertex_count());
    for (std::size_t k = 0; k < stiffness.size(); ++k)
        pulls[regions.soft()[k].vertex] += stiffness[k];
    for (int v = 0; v < regions.vertex_count(); ++v)
        if (regions.is_free(v))
            system.vertices.push_back(v);
    system.pulls = pulls(system.vertices);
    auto grid = std::make_unique<const MultigridSolver>(system, progress);
    system = {};
    exchange(regions, std::move(stiffness), std::move(grid), completed);
    equations_.restore({});
}

void ConstrainedSystem::exchange(const Regions& regions, std::vector<double> stiffness,
                                 std::unique_ptr<const MultigridSolver> grid,
                                 const std::function<void()>& completed)
{
    std::vector<Constraint> constraints = regions.constraints();
    const auto swap = [&] {
        constraints_.swap(constraints);
        stiffness_.swap(stiffness);
        grid_.swap(grid);
    };
    swap();
    try {
        if (completed)
            completed();
    } catch (const std::exception&) {
        swap();
        throw;
    }
    frames_ = std::make_unique<Pool<Frame>>();
}

SolveReport ConstrainedSystem::solve(const Targets& targets, Points& positions, const Source& source,
                                     const Iterating& how) const
{
    SolveReport report;
    solve(targets, positions, source, &report, how);
    return report;
}

void ConstrainedSystem::displace(const Targets& targets, Points& positions, const Source& source) const
{
    solve(targets, positions, source, nullptr, {});
}

void ConstrainedSystem::solve(const Targets& targets, Points& positions, const Source& source,
                              SolveReport* report, const Iterating& how) const
{
    if (grid_ && SolvedSystem::of_thread())
        throw InvalidOption("solver: the multigrid has no matrix; choose the factor");
    const PointsView base = targets.base();
    const int n = static_cast<int>(base.rows());
    const bool loaded = source || !stiffness_.empty();
    const auto frame = frames_->take([&] {
        auto made = std::make_unique<Frame>();
        made->d = RowMatrix::Zero(n, 3);
        made->b = RowMatrix::Zero(loaded ? n : 0, 3);
        return made;
    });
    RowMatrix &d = frame->d, &b = frame->b;
    double energy = 0.0; // twice E
    if (source)
        energy = source(b);
    else
        for (std::size_t row = constraints_.size() - stiffness_.size(); row < constraints_.size(); ++row)
            b.row(constraints_[row].vertex).setZero();
    for (std::size_t row = 0; row < constraints_.size(); ++row) {
        const auto [vertex, handle] = constraints_[row];
        const Vector3 wanted = targets.position(vertex, handle) - base.row(vertex).transpose();
        if (is_soft(row)) {
            b.row(vertex) += stiffness(row) * wanted.transpose();
            energy += stiffness(row) * wanted.squaredNorm();
        } else {
            d.row(vertex) = wanted.transpose();
        }
    }

    const RowMatrix* const rhs = loaded ? &b : nullptr;
    MultigridSolver::Solution iterated;
    if (grid_) {
        const RowMatrix start = how.start ? RowMatrix(*how.start - base) : RowMatrix();
        iterated = grid_->solve(d, rhs, how.start ? &start : nullptr, how.progress);
    } else {
        equations_.solve(d, rhs, frame->work);
    }
    positions.resize(n, 3);
    parallel_for(n, [&](int i) {
        for (int axis = 0; axis < 3; ++axis)
            positions(i, axis) = base(i, axis) + d(i, axis);
    });

    if (!report)
        return;
    const ConstrainedQuadratic::Norms norms = grid_ ? iterated.norms : equations_.norms(d, rhs);
    energy += norms.energy; // with s_i |d_i|^2, as the pulls are on the diagonal
    if (loaded)
        energy -= 2 * parallel_sum(n, [&](int i) { return d.row(i).dot(b.row(i)); });
    report->iterations = grid_ ? iterated.iterations : 1;
    report->converged = true;
    report->energy = std::max(0.0, 0.5 * energy); // rounding may take it below
    report->residual = norms.load > 0 ? std::sqrt(norms.residual / norms.load) : 0.0;
}

void ConstrainedSystem::solve(RowMatrix& d, const RowMatrix* b, const Progress& progress) const
{
    if (grid_)
        grid_->solve(d, b, nullptr, progress);
    else
        equations_.solve(d, b);
}

RowMatrix ConstrainedSystem::spread(const MatrixX& constraints, const Progress& progress) const
{
    std::optional<RowMatrix> b;
    return spread(constraints, b, progress);
}

RowMatrix ConstrainedSystem::spread(const MatrixX& constraints, std::optional<RowMatrix>& b,
                                    const Progress& progress) const
{
    if (!grid_ && !equations_.problem().matrix)
        throw InvalidConstraint("there are no handles yet: call set_handles() first");
    const auto columns = constraints.cols();
    const auto n = grid_ ? grid_->rows() : static_cast<Eigen::Index>(equations_.problem().free.size());
    RowMatrix d = RowMatrix::Zero(n, columns);
    if (!stiffness_.empty())
        b = RowMatrix::Zero(n, columns);
    for (std::size_t row = 0; row < constraints_.size(); ++row) {
        const int vertex = constraints_[row].vertex;
        const auto target = constraints.row(static_cast<Eigen::Index>(row));
        if (is_soft(row))
            b->row(vertex) += stiffness(row) * target;
        else
            d.row(vertex) = target;
    }
    solve(d, b ? &*b : nullptr, progress);
    return d;
}

RowMatrix ConstrainedSystem::answer(const RowMatrix& b, const Progress& progress) const
{
    RowMatrix d = RowMatrix::Zero(b.rows(), b.cols());
    solve(d, &b, progress);
    return d;
}

LinearResponse ConstrainedSystem::respond(const MatrixX& constraints) const
{
    if (grid_)
        throw InvalidOption("solver: the multigrid has no matrix; choose the factor");
    const auto columns = constraints.cols();
    std::optional<RowMatrix> b;
    LinearResponse response;
    RowMatrix& d = response.displacement;
    d = spread(constraints, b, {});
    ConstrainedQuadratic::Forms forms = equations_.forms(d, b ? &*b : nullptr);
    response.energy = std::move(forms.energy);
    if (b) { // as in solve()
        MatrixX soft = MatrixX::Zero(columns, columns);
        for (std::size_t row = constraints_.size() - stiffness_.size(); row < constraints_.size(); ++row) {
            const auto target = constraints.row(static_cast<Eigen::Index>(row));
            soft += stiffness(row) * target.transpose() * target;
        }
        const MatrixX cross = transposed_product(d, *b);
        response.energy += soft - cross - cross.transpose();
    }
    response.residual = std::move(forms.residual);
    response.load = std::move(forms.load);
    return response;
}

void ConstrainedSystem::report(BindReport& report, const std::string& why) const
{
    report.factorizations = factorizations_;
    if (grid_) {
        report.factor_bytes = grid_->bytes();
        remark_iterations(report, why);
        return;
    }
    const SpdFactor& factor = equations_.factor();
    report.analyses = factor.analyses();
    report.refactored = factor.share();
    report.factor_bytes = factor.bytes();
}

} // namespace sinew
