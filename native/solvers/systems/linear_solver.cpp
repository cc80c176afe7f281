// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/systems/linear_solver.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/solvers/multigrid/cycles.h"
#include "native/solvers/spd_factor.h"
#include "native/solvers/systems/conjugate_gradients.h"
#include "native/solvers/systems/direct.h"
#include "native/solvers/systems/not_converged.h"

#include <Eigen/IterativeLinearSolvers>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

namespace sinew {

namespace {

constexpr double wrong = 1e-2; ///< share of the right side that a solution leaves only of a singular system
constexpr int most_cycles = 500;

class Clock
{
public:
    /// Seconds since it was made, or asked last.
    double lap()
    {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

bool is_dense(Solver solver) { return solver >= Solver::dense_cholesky; }

bool needs_symmetry(Solver solver)
{
    return solver != Solver::lu && solver != Solver::dense_lu && solver != Solver::dense_qr &&
           solver != Solver::dense_svd;
}

/// A pair of entries (i, j), (j, i) that differ; none in a symmetric matrix.
std::optional<std::pair<int, int>> asymmetry(const SparseMatrix& A)
{
    constexpr double rounding = 1e-10;
    const SparseMatrix transposed = A.transpose();
    const int n = static_cast<int>(A.cols());
    for (int c = 0; c < n; ++c) {
        SparseMatrix::InnerIterator a(A, c), b(transposed, c);
        while (a || b) {
            const auto row = std::min(a ? a.row() : A.rows(), b ? b.row() : A.rows());
            const double x = a && a.row() == row ? a.value() : 0.0, y = b && b.row() == row ? b.value() : 0.0;
            if (std::abs(x - y) > rounding * std::max(std::abs(x), std::abs(y)) &&
                std::abs(x - y) > rounding * std::sqrt(std::abs(A.coeff(row, row) * A.coeff(c, c))))
                return std::pair{static_cast<int>(row), c};
            if (a && a.row() == row)
                ++a;
            if (b && b.row() == row)
                ++b;
        }
    }
    return {};
}

/// \throw InvalidOption
void check(const LinearSystem& system, const RowMatrix& B, const SolverOptions& options)
{
    const SparseMatrix& A = system.matrix;
    const auto in_words = [](Eigen::Index rows, Eigen::Index columns) {
        return "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")";
    };
    if (A.rows() != A.cols())
        throw InvalidOption("matrix: " + in_words(A.rows(), A.cols()) + " is not square");
    if (B.rows() != A.rows())
        throw InvalidOption("b: " + std::to_string(B.rows()) + " rows given for a matrix of " +
                            std::to_string(A.rows()));
    for (int c = 0; c < A.cols(); ++c)
        for (SparseMatrix::InnerIterator it(A, c); it; ++it)
            if (!std::isfinite(it.value()))
                throw InvalidOption("matrix: NaN or infinite entry in column " + std::to_string(c));
    for (Eigen::Index i = 0; i < B.rows(); ++i)
        if (!B.row(i).allFinite())
            throw InvalidOption("b: NaN or infinite entry in row " + std::to_string(i));
    require_in_range(options.tolerance, from_to_below(0.0, 1.0), "tolerance");
    require_in_range(options.max_iterations, at_least(1), "max_iterations");
    if (is_dense(options.solver) && A.cols() > most_dense)
        throw InvalidOption("solver: dense ones are for at most " + std::to_string(most_dense) +
                            " unknowns, not for " + std::to_string(A.cols()) + "; choose cholesky or lu");
}

/// Solves for any number of columns, and writes iterations and the like into the report.
using Solve = std::function<RowMatrix(const RowMatrix&, SolutionReport&)>;

Columns four_of(const RowMatrix& B, Eigen::Index first)
{
    Columns columns(B.rows());
    const auto count = std::min<Eigen::Index>(4, B.cols() - first);
    for (Eigen::Index i = 0; i < B.rows(); ++i) {
        columns[i].setZero();
        columns[i].head(count) = B.row(i).segment(first, count).transpose().array();
    }
    return columns;
}

/// Runs an iteration for four columns at a time, each time from begin(b).
Solve iterated(const LinearSystem& system, const SolverOptions& options, Measure measure, Preconditioner B,
               std::function<void(const Columns& b, Eigen::Index first, Columns& x)> begin,
               const Progress& progress)
{
    return [&system, &progress, B = std::move(B), begin = std::move(begin),
            stop = Stop{options.tolerance,
                        measure == Measure::error ? std::min(options.max_iterations, most_cycles)
                                                  : options.max_iterations,
                        measure}](const RowMatrix& b, SolutionReport& report) {
        RowMatrix x(b.rows(), b.cols());
        for (Eigen::Index first = 0; first < b.cols(); first += 4) {
            const Columns load = four_of(b, first);
            Columns found(load.size(), Eigen::Array4d(Eigen::Array4d::Zero()));
            if (begin)
                begin(load, first, found);
            const Iteration done = conjugate_gradients(system.matrix, load, found, B, stop, progress);
            report.iterations = std::max(report.iterations, done.count);
            if (!done.converged)
                throw NotConverged("max_iterations: after " + std::to_string(done.count) +
                                   " iterations the tolerance of " + shortest(stop.tolerance, 2) +
                                   " is not met, but " + shortest(done.reached, 2));
            const auto count = std::min<Eigen::Index>(4, b.cols() - first);
            for (Eigen::Index i = 0; i < b.rows(); ++i)
                x.row(i).segment(first, count) = found[i].head(count).transpose().matrix();
        }
        return x;
    };
}

Preconditioner by_diagonal(const SparseMatrix& A)
{
    VectorX inverse = A.diagonal();
    for (Eigen::Index i = 0; i < inverse.size(); ++i) {
        if (!(inverse[i] > 0))
            throw FactorizationFailed("the matrix is not positive definite: entry " + std::to_string(i) +
                                          " of its diagonal is not positive",
                                      Error::Element::vertex, {static_cast<int>(i)});
        inverse[i] = 1.0 / inverse[i];
    }
    return [inverse = std::move(inverse)](const Columns& r, Columns& z) {
        parallel_for(static_cast<int>(r.size()), [&](int i) { z[i] = inverse[i] * r[i]; });
    };
}

Preconditioner incomplete(const SparseMatrix& A, bool may_shift, SolutionReport& report)
{
    using Factor = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::AMDOrdering<int>>;
    const auto factor = std::make_shared<Factor>(A);
    const auto broken = [](const std::string& more) {
        throw FactorizationFailed("the incomplete Cholesky factor breaks down" + more);
    };
    if (factor->info() != Eigen::Success)
        broken("; choose jacobi");
    // The first pivot is an entry of the scaled diagonal and the shift, of which Eigen does not speak.
    Eigen::Index place = 0;
    for (Eigen::Index i = 0; i < factor->permutationP().size(); ++i)
        if (factor->permutationP().indices()[i] == 0)
            place = i;
    const double scale = factor->scalingS()[0], pivot = factor->matrixL().coeff(0, 0);
    const double shift = pivot * pivot - scale * scale * A.coeff(place, place);
    if (shift > 1e-9) {
        if (!may_shift)
            broken("; choose shifted_incomplete_cholesky or jacobi");
        report.why +=
            "; the incomplete factor broke down, so the diagonal was raised by " + shortest(shift, 2);
    }
    const std::int64_t entries = factor->matrixL().nonZeros();
    report.fill = static_cast<double>(entries) / (0.5 * static_cast<double>(A.nonZeros() + A.cols()));
    report.bytes = entries * static_cast<std::int64_t>(sizeof(double) + sizeof(int));
    return [factor](const Columns& r, Columns& z) {
        VectorX column(static_cast<Eigen::Index>(r.size()));
        for (int c = 0; c < 4; ++c) {
            for (std::size_t i = 0; i < r.size(); ++i)
                column[static_cast<Eigen::Index>(i)] = r[i][c];
            if (column.squaredNorm() > 0)
                column = factor->solve(column).eval();
            for (std::size_t i = 0; i < r.size(); ++i)
                z[i][c] = column[static_cast<Eigen::Index>(i)];
        }
    };
}

/// Cycles between vectors of unknowns in double precision.
struct Multigrid
{
    Hierarchy hierarchy;
    Cycles cycles;

    Multigrid(const LinearSystem& system, const Progress& progress)
        : hierarchy(system, progress), cycles(hierarchy)
    {
    }

    /// to = cycle(unit) of `from`, of which each column is scaled so that single precision holds it; that is 1 there what
    /// is `unit` in `to`.
    template <class Cycle>
    void apply(const Columns& from, Columns& to, const Cycle& cycle)
    {
        Eigen::Array4d size = Eigen::Array4d::Zero();
        for (const Eigen::Array4d& row : from)
            size = size.max(row.abs());
        size = (size > 0).select(size, 1.0);
        const int n = static_cast<int>(hierarchy.unknowns.size());
        std::vector<Four>& b = cycles.right_side();
        parallel_for(n, [&](int i) { b[i] = (from[hierarchy.unknowns[i]] / size).cast<float>(); });
        const Wide unit = hierarchy.scale * size;
        const std::vector<Wide>& x = cycle(unit);
        parallel_for(n, [&](int i) { to[hierarchy.unknowns[i]] = unit * x[i]; });
    }

    /// Nested iteration, from the values of held nodes where they are known and b follows from them.
    void guess(const LinearSystem& system, const Columns& b, Eigen::Index first, Columns& x)
    {
        if (system.held.size() == 0)
            return apply(b, x, [&](const Wide&) { return cycles.full_cycle({}); });
        const SparseMatrix& L = system.graph;
        const int n = static_cast<int>(L.cols());
        const Columns d = four_of(system.held, first);
        Columns change(n);
        const auto multiply = [&](const Columns& from, int v) {
            Wide sum = Wide::Zero();
            for (SparseMatrix::InnerIterator it(L, v); it; ++it)
                sum += it.value() * (from[it.row()] - from[v]);
            return sum;
        };
        if (hierarchy.order == 2)
            parallel_for(n, [&](int v) {
                change[v] = (system.mass.size() > 0 ? 1.0 / system.mass[v] : 1.0) * multiply(d, v) +
                            system.membrane * d[v];
            });
        const Columns& middle = hierarchy.order == 2 ? change : d;
        Columns f = b;
        parallel_for(static_cast<int>(f.size()),
                     [&](int u) { f[u] += multiply(middle, system.vertices[u]); });
        std::vector<bool> inside(n, false);
        for (const int v : hierarchy.held)
            inside[v] = true;
        for (const int v : system.vertices)
            inside[v] = true;
        HeldValues held;
        for (const int v : hierarchy.held) {
            Wide sum = Wide::Zero();
            for (SparseMatrix::InnerIterator it(L, v); it; ++it)
                if (!inside[it.row()])
                    sum += it.value() * (d[it.row()] - d[v]);
            held.value.push_back(d[v]);
            held.beyond.push_back(sum / hierarchy.weight);
        }
        apply(f, x, [&](const Wide& unit) {
            for (std::vector<Wide>* each : {&held.value, &held.beyond})
                for (Wide& value : *each)
                    value /= unit;
            return cycles.full_cycle(held);
        });
    }
};

/// One V-cycle.
/// \throw NotConverged  the operator is not positive definite, or too far from that.
const std::vector<Wide>& definite(Cycles& cycles)
{
    if (const std::vector<Wide>* const x = cycles.cycle())
        return *x;
    throw NotConverged("the V-cycle diverges on this system; choose cholesky");
}

Solve prepare_multigrid(const LinearSystem& system, const SolverOptions& options, SolutionReport& report,
                        const Progress& progress)
{
    if (static_cast<Eigen::Index>(system.vertices.size()) != system.matrix.cols())
        throw InvalidOption("multigrid needs the points and the graph of the system; choose another solver");
    const auto grid = std::make_shared<Multigrid>(system, progress);
    report.levels = static_cast<int>(grid->hierarchy.levels.size());
    report.bytes = grid->hierarchy.bytes() + grid->cycles.bytes();
    const auto begin = [grid, &system, cycle = options.cycle](const Columns& b, Eigen::Index first,
                                                              Columns& x) {
        if (cycle == Cycle::full)
            grid->guess(system, b, first, x);
        if (cycle == Cycle::cascading)
            grid->apply(b, x,
                        [&](const Wide&) -> const std::vector<Wide>& { return grid->cycles.descend(); });
    };
    if (options.cycle == Cycle::cascading)
        return iterated(system, options, Measure::residual, by_diagonal(system.matrix), begin, progress);
    return iterated(
        system, options, Measure::error,
        [grid, &report](const Columns& r, Columns& z) {
            const int raises = grid->cycles.raises();
            grid->apply(r, z,
                        [&](const Wide&) -> const std::vector<Wide>& { return definite(grid->cycles); });
            if (raises == 0 && grid->cycles.raises() > 0)
                report.why += "; the bounds of the smoother were raised";
        },
        begin, progress);
}

/// \param order  of elimination, for the sparse Cholesky factors.
Solve prepare(const LinearSystem& system, const SolverOptions& options, std::vector<int> order,
              SolutionReport& report, const Progress& progress)
{
    const SparseMatrix& A = system.matrix;
    switch (report.solver) {
    case Solver::conjugate_gradients:
        switch (options.preconditioner) {
        case Precondition::none:
            return iterated(
                system, options, Measure::residual, [](const Columns& r, Columns& z) { z = r; }, {},
                progress);
        case Precondition::jacobi:
            return iterated(system, options, Measure::residual, by_diagonal(A), {}, progress);
        default:
            return iterated(
                system, options, Measure::residual,
                incomplete(A, options.preconditioner == Precondition::shifted_incomplete_cholesky, report),
                {}, progress);
        }
    case Solver::multigrid:
        return prepare_multigrid(system, options, report, progress);
    default:
        break;
    }
    DirectNumbers numbers;
    std::function<RowMatrix(const RowMatrix&)> solve =
        factorized(A, report.solver, std::move(order), numbers);
    report.bytes = numbers.bytes;
    report.fill = static_cast<double>(numbers.entries) / (0.5 * static_cast<double>(A.nonZeros() + A.cols()));
    return [solve = std::move(solve)](const RowMatrix& b, SolutionReport&) { return solve(b); };
}

std::int64_t envelope_of(const SparseMatrix& A, const std::vector<int>& order)
{
    std::vector<int> when(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        when[order[k]] = static_cast<int>(k);
    std::int64_t sum = 0;
    for (int c = 0; c < A.cols(); ++c) {
        int first = when[c];
        for (SparseMatrix::InnerIterator it(A, c); it; ++it)
            first = std::min(first, when[it.row()]);
        sum += when[c] - first + 1;
    }
    return sum;
}

/// Chooses the solver, and says why.
Solver choose(const LinearSystem& system, const SolverOptions& options, std::string& why)
{
    const auto different = asymmetry(system.matrix);
    if (options.solver != Solver::automatic) {
        if (different && needs_symmetry(options.solver))
            throw InvalidOption("matrix: not symmetric, entries (" + std::to_string(different->first) + ", " +
                                std::to_string(different->second) + ") and (" +
                                std::to_string(different->second) + ", " + std::to_string(different->first) +
                                ") differ; choose lu");
        why = "asked for";
        return options.solver;
    }
    why =
        different ? "the matrix is not symmetric" : "the matrix is symmetric and its factor fits the memory";
    return different ? Solver::lu : Solver::cholesky;
}

} // namespace

RowMatrix solve_linear(const LinearSystem& system, const RowMatrix& B, const SolverOptions& options,
                       SolutionReport& report, const Progress& progress)
{
    check(system, B, options);
    const SparseMatrix& A = system.matrix;
    Clock clock;
    report = {};
    report.solver = choose(system, options, report.why);
    if (options.error_bound && asymmetry(system.matrix))
        throw InvalidOption("error_bound: the matrix is not symmetric");
    if (A.cols() == 0)
        return B;
    std::vector<int> order;
    if (report.solver == Solver::cholesky || report.solver == Solver::simplicial) {
        order = elimination_order(A, options.ordering);
        report.envelope = envelope_of(A, order);
    } else if (options.ordering != Ordering::automatic) {
        throw InvalidOption("ordering: only cholesky and simplicial take one");
    }
    report.setup = clock.lap();
    progress.tick(0.0, "preparing the solver");
    Solve solve;
    try {
        solve = prepare(system, options, std::move(order), report, progress);
    } catch (const OutOfMemory&) {
        if (options.solver != Solver::automatic || !system.has_nodes() || system.order > 2)
            throw;
        report.solver = Solver::multigrid;
        report.why = "the factor needs more memory than there is";
        solve = prepare(system, options, {}, report, progress);
    }
    report.precompute = clock.lap();
    progress.tick(0.0, "solving");
    RowMatrix x = solve(B, report);
    report.solve = clock.lap();

    if (!x.allFinite())
        throw FactorizationFailed("the matrix is singular: its solution is not finite");
    const RowMatrix residual = B - A * x;
    double largest = 0.0,
           work = 0.0; // what is left of x . b, which does not count rough errors as b - A x does
    for (Eigen::Index c = 0; c < B.cols(); ++c) {
        const double load = B.col(c).norm(), left = residual.col(c).norm();
        report.residual = std::max(report.residual, load > 0 ? left / load : left);
        largest = std::max(largest, left);
        if (load > 0)
            work = std::max(work, std::abs(x.col(c).dot(residual.col(c)) / x.col(c).dot(B.col(c))));
    }
    const double most = std::max(wrong, 10 * options.tolerance); // of a coarse tolerance the user knows
    if (report.solver == Solver::multigrid ? !(work < most) : report.residual > most)
        throw FactorizationFailed("the matrix is singular up to rounding: |b - A x| / |b| is " +
                                  shortest(report.residual, 2));
    if (options.error_bound) {
        SolutionReport unread;
        const auto inverse = [&](const VectorX& v) { return VectorX(solve(v, unread).col(0)); };
        report.error_bound = largest * norm_of(static_cast<int>(A.cols()), inverse);
    }
    return x;
}

} // namespace sinew
