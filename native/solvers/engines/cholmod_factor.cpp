// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/engines/cholmod_factor.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/system/memory_advice.h"
#include "native/solvers/supernodal/factor.h"
#include "native/solvers/supernodal/kernels.h"
#include "native/solvers/supernodal/solve.h"

#ifdef SINEW_HAVE_CHOLMOD

#include <cholmod.h>
#ifdef SINEW_HAVE_OPENMP
#include <omp.h>
#endif
#ifdef __ELF__
// These exist only if the BLAS is OpenBLAS. Other formats of binaries have no references that may stay open.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));
extern "C" int openblas_get_parallel() __attribute__((weak));
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <new>
#include <numeric>
#include <optional>
#include <string>

namespace sinew {

namespace {

/// For more columns than this, CHOLMOD is faster than SupernodalSolve, as it reads the factor less often.
constexpr int most_own_columns = 16;

constexpr int fewest_to_merge_sparingly = 50'000; ///< rows

enum class Blas { unknown, serial, pthread, openmp };

Blas blas()
{
#ifdef __ELF__
    if (openblas_get_parallel)
        return std::array{Blas::serial, Blas::pthread, Blas::openmp}[openblas_get_parallel() % 3];
#endif
    return Blas::unknown;
}

/// Limits CHOLMOD and the BLAS to one thread while a call runs. CHOLMOD's own OpenMP loops leave spinning
/// threads behind, which make every later loop on a small machine up to ten times slower, and for blocks of
/// these sizes a BLAS of several threads is no faster. The serial build of OpenBLAS allows only one caller at
/// a time, so calls wait for each other; its OpenMP build hangs if OpenMP may have no active levels.
class ThreadGuard
{
public:
    ThreadGuard()
    {
        static std::mutex queue;
        if (blas() == Blas::serial)
            turn_ = std::unique_lock(queue);
#ifdef SINEW_HAVE_OPENMP
        levels_ = omp_get_max_active_levels();
        if (blas() != Blas::openmp)
            omp_set_max_active_levels(0);
#endif
#ifdef __ELF__
        if (openblas_set_num_threads)
            openblas_set_num_threads(1);
#endif
    }
    ~ThreadGuard()
    {
#ifdef SINEW_HAVE_OPENMP
        omp_set_max_active_levels(levels_);
#endif
    }
    ThreadGuard(const ThreadGuard&) = delete;
    ThreadGuard& operator=(const ThreadGuard&) = delete;

private:
    std::unique_lock<std::mutex> turn_;
#ifdef SINEW_HAVE_OPENMP
    int levels_ = 1;
#endif
};

/// A cholmod_common. It is only a workspace, so each call has its own, and several may solve at once.
class Workspace
{
public:
    Workspace()
    {
        cholmod_start(&common_);
        common_.print = 0;
        common_.error_handler = nullptr;
        common_.nmethods = 1;
        common_.method[0].ordering = CHOLMOD_GIVEN;
        common_.postorder = true;
        common_.final_ll = true;
        common_.quick_return_if_not_posdef = true;
    }
    ~Workspace() { cholmod_finish(&common_); }
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;

    cholmod_common* get() { return &common_; }

private:
    cholmod_common common_;
    ThreadGuard guard_;
};

/// A view of the lower triangle of a matrix; CHOLMOD does not write to it.
cholmod_sparse view(const SparseMatrix& matrix)
{
    cholmod_sparse s{};
    s.nrow = matrix.rows();
    s.ncol = matrix.cols();
    s.nzmax = matrix.nonZeros();
    s.p = const_cast<int*>(matrix.outerIndexPtr());
    s.i = const_cast<int*>(matrix.innerIndexPtr());
    s.x = const_cast<double*>(matrix.valuePtr());
    s.stype = -1;
    s.itype = CHOLMOD_INT;
    s.xtype = CHOLMOD_REAL;
    s.dtype = CHOLMOD_DOUBLE;
    s.sorted = true;
    s.packed = true;
    return s;
}

/// A view of the pattern; CHOLMOD does not write to it.
cholmod_sparse view(const Graph& graph)
{
    cholmod_sparse s{};
    s.nrow = s.ncol = graph.size();
    s.nzmax = graph.neighbours.size();
    s.p = const_cast<int*>(graph.offsets.data());
    s.i = const_cast<int*>(graph.neighbours.data());
    s.itype = CHOLMOD_INT;
    s.xtype = CHOLMOD_PATTERN;
    s.dtype = CHOLMOD_DOUBLE;
    s.packed = true;
    return s;
}

/// METIS starts rand() anew and draws from it. Other threads that did the same would change the ordering, and with it
/// the last bits of results.
std::mutex& random_numbers()
{
    static std::mutex mutex;
    return mutex;
}

/// The symbolic part of supernodal factors.
struct Symbolic final : Analysis
{
    explicit Symbolic(cholmod_factor* found) : factor(found) {}
    ~Symbolic() override
    {
        Workspace workspace;
        cholmod_free_factor(&factor, workspace.get());
    }

    cholmod_factor* factor;
};

class CholmodFactor final : public FactorEngine
{
public:
    explicit CholmodFactor(bool supernodal) : supernodal_(supernodal) {}
    ~CholmodFactor() override { release(); }

    void analyze(const SparseMatrix& matrix, const std::vector<int>& order) override
    {
        release();
        cholmod_factor* const found = analyzed(matrix, order);
        if (found->is_super)
            adopt(std::make_shared<const Symbolic>(found));
        else
            factor_ = found;
    }

    std::shared_ptr<const Analysis> analysis() const override { return symbolic_; }

    void adopt(const std::shared_ptr<const Analysis>& analysis) override
    {
        release();
        symbolic_ = std::static_pointer_cast<const Symbolic>(analysis);
        own_factor_ = *symbolic_->factor; // with its arrays, and later with values of its own
        factor_ = &own_factor_;
    }

    int factorize(const SparseMatrix& matrix) override
    {
        own_.reset();
        Workspace workspace;
        if (factor_->is_super) {
            std::vector<int> all(matrix.cols());
            std::iota(all.begin(), all.end(), 0);
            const std::vector<bool> free(matrix.cols(), true);
            if (has_upper_triangle(matrix))
                return factorize_supernodes({matrix, all, free}, workspace.get());
            const SparseMatrix both = matrix.selfadjointView<Eigen::Lower>();
            return factorize_supernodes({both, all, free}, workspace.get());
        }
        cholmod_sparse a = view(matrix);
        cholmod_factorize(&a, factor_, workspace.get());
        if (workspace.get()->status == CHOLMOD_NOT_POSDEF)
            return static_cast<const int*>(factor_->Perm)[std::min(factor_->minor, factor_->n - 1)];
        if (workspace.get()->status != CHOLMOD_OK)
            refuse(workspace.get()->status);
        nonzeros_ = count_entries();
        return -1;
    }

    int factorize(const PrincipalBlock& block) override
    {
        if (!factor_->is_super)
            return factorize(block.copy());
        own_.reset();
        Workspace workspace;
        return factorize_supernodes(block, workspace.get());
    }

    std::optional<int> update(const PrincipalBlock& block, const std::vector<int>& changed, double most,
                              double& share) override
    {
        if (!own_)
            return {};
        const SupernodalFactor structure = supernodes();
        std::vector<int> position(structure.size);
        for (int k = 0; k < structure.size; ++k)
            position[structure.permutation[k]] = k;
        std::vector<int> reached;
        for (const int unknown : changed)
            reached.push_back(position[unknown]);
        const std::vector<char> chosen = supernodes_above(structure, reached);
        const std::vector<double> work = supernodal_work(structure);
        double total = 0, done = 0;
        for (int s = 0; s < structure.supernodes; ++s) {
            total += work[s];
            done += chosen[s] ? work[s] : 0;
        }
        if (done > most * total)
            return {};
        share = done / total;
        Workspace workspace;
        const int broken = compute(block, chosen);
        if (broken < 0)
            own_->renew(chosen);
        return broken;
    }

    void solve_rows(RowMatrix& x) const override
    {
        if (!own_ || x.cols() > most_own_columns) {
            FactorEngine::solve_rows(x);
            return;
        }
        for (int c = 0; c < x.cols(); c += lane_count)
            own_->solve_rows(x, c, std::min<int>(lane_count, static_cast<int>(x.cols()) - c));
    }

    void solve(const MatrixX& rhs, MatrixX& solution) const override
    {
        if (own_ && rhs.cols() <= lane_count) {
            own_->solve(rhs, solution);
            return;
        }
        Workspace workspace;
        cholmod_dense b{};
        b.nrow = rhs.rows();
        b.ncol = rhs.cols();
        b.nzmax = rhs.size();
        b.d = rhs.rows();
        b.x = const_cast<double*>(rhs.data());
        b.xtype = CHOLMOD_REAL;
        b.dtype = CHOLMOD_DOUBLE;
        cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor_, &b, workspace.get());
        if (!x)
            refuse(workspace.get()->status);
        solution = Eigen::Map<const MatrixX>(static_cast<const double*>(x->x), rhs.rows(), rhs.cols());
        cholmod_free_dense(&x, workspace.get());
    }

    std::optional<SupernodalFactor> supernodal() const override
    {
        return own_ ? std::optional(supernodes()) : std::nullopt;
    }

    VectorX pivots() const override
    {
        const auto n = static_cast<int>(factor_->n);
        const auto* order = static_cast<const int*>(factor_->Perm);
        const auto* L = static_cast<const double*>(factor_->x);
        VectorX pivots(n);
        if (!factor_->is_super) {
            const auto* columns = static_cast<const int*>(factor_->p);
            for (int k = 0; k < n; ++k)
                pivots[order[k]] = std::pow(L[columns[k]], 2);
            return pivots;
        }
        const auto* first = static_cast<const int*>(factor_->super);
        const auto* rows = static_cast<const int*>(factor_->pi);
        const auto* blocks = static_cast<const int*>(factor_->px);
        for (std::size_t s = 0; s < factor_->nsuper; ++s) {
            const int height = rows[s + 1] - rows[s];
            for (int k = first[s]; k < first[s + 1]; ++k)
                pivots[order[k]] = std::pow(L[blocks[s] + (k - first[s]) * (height + 1)], 2);
        }
        return pivots;
    }

    std::int64_t bytes() const override
    {
        const auto n = static_cast<std::int64_t>(factor_->n);
        if (factor_->is_super)
            return static_cast<std::int64_t>(factor_->xsize * sizeof(double) +
                                             (factor_->ssize + 3 * factor_->nsuper) * sizeof(int)) +
                   2 * n * static_cast<std::int64_t>(sizeof(int));
        const auto* counts = static_cast<const int*>(factor_->ColCount);
        const std::int64_t entries = std::accumulate(counts, counts + n, std::int64_t{0});
        return entries * static_cast<std::int64_t>(sizeof(double) + sizeof(int)) +
               6 * n * static_cast<std::int64_t>(sizeof(int));
    }

    std::int64_t nonzeros() const override { return nonzeros_; }

private:
    [[noreturn]] void refuse(int status) const
    {
        if (status == CHOLMOD_OUT_OF_MEMORY)
            throw std::bad_alloc();
        throw FactorizationFailed("CHOLMOD failed with status " + std::to_string(status));
    }

    /// The result of cholmod_analyze_p(), which belongs to the caller.
    cholmod_factor* analyzed(const SparseMatrix& matrix, const std::vector<int>& order) const
    {
        Workspace workspace;
        workspace.get()->supernodal = supernodal_ ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
        if (matrix.cols() >= fewest_to_merge_sparingly) {
            // Supernodes are merged where they are narrower than so many columns and the zeros stored for it are
            // at most such a share. CHOLMOD's own limits cost 4 % of memory and 8 % of a bind at 500,000 rows;
            // for small factors they take fewer instructions.
            std::ranges::copy(std::array{2, 8, 24}, workspace.get()->nrelax);
            std::ranges::copy(std::array{0.2, 0.03, 0.01}, workspace.get()->zrelax);
        }
        cholmod_sparse a = view(matrix);
        std::vector<int> permutation = order;
        cholmod_factor* const found = cholmod_analyze_p(&a, permutation.data(), nullptr, 0, workspace.get());
        if (!found) {
            if (workspace.get()->status == CHOLMOD_TOO_LARGE)
                throw OutOfMemory("the factor needs at least " +
                                  in_words(static_cast<std::int64_t>(8 * workspace.get()->lnz)) +
                                  ", more than can be addressed: use fewer vertices");
            refuse(workspace.get()->status);
        }
        return found;
    }

    /// Computes the values of CHOLMOD's own factor in place, so that CHOLMOD can solve for many columns.
    int factorize_supernodes(const PrincipalBlock& block, cholmod_common* common)
    {
        if (!factor_->x) {
            return_freed_memory(); // that of ordering and analysis, before the large factor is allocated
            factor_->x = cholmod_malloc(factor_->xsize + SupernodalFactor::padding, sizeof(double), common);
            if (!factor_->x)
                refuse(common->status);
            std::fill_n(static_cast<double*>(factor_->x) + factor_->xsize, SupernodalFactor::padding, 0.0);
            factor_->xtype = CHOLMOD_REAL;
            ask_for_large_pages(factor_->x, factor_->xsize * sizeof(double));
        }
        nonzeros_ = count_entries();
        const int broken = compute(block, {});
        if (broken < 0)
            own_ = std::make_unique<SupernodalSolve<double>>(supernodes());
        return broken;
    }

    /// Computes the values of the chosen supernodes; of all if `chosen` is empty.
    int compute(const PrincipalBlock& block, const std::vector<char>& chosen)
    {
        const SupernodalFactor structure = supernodes();
        const int broken = factorize_supernodal(structure, block, chosen, blas() != Blas::serial);
        return broken < 0 ? -1 : structure.permutation[broken];
    }

    SupernodalFactor supernodes() const
    {
        return {.size = static_cast<int>(factor_->n),
                .supernodes = static_cast<int>(factor_->nsuper),
                .permutation = static_cast<const int*>(factor_->Perm),
                .first = static_cast<const int*>(factor_->super),
                .row_begin = static_cast<const int*>(factor_->pi),
                .block_begin = static_cast<const int*>(factor_->px),
                .rows = static_cast<const int*>(factor_->s),
                .values = static_cast<double*>(factor_->x)};
    }

    static bool has_upper_triangle(const SparseMatrix& matrix)
    {
        for (int c = 0; c < matrix.cols(); ++c)
            if (SparseMatrix::InnerIterator first(matrix, c); first && first.row() < c)
                return true;
        return false;
    }

    std::int64_t count_entries() const
    {
        if (factor_->is_super)
            return static_cast<std::int64_t>(factor_->xsize);
        const int* columns = static_cast<const int*>(factor_->nz);
        std::int64_t total = 0;
        for (std::size_t c = 0; c < factor_->n; ++c)
            total += columns[c];
        return total;
    }

    void release()
    {
        own_.reset();
        if (factor_) {
            Workspace workspace;
            if (symbolic_)
                cholmod_free(factor_->xsize, sizeof(double), factor_->x, workspace.get());
            else
                cholmod_free_factor(&factor_, workspace.get());
            factor_ = nullptr;
        }
        symbolic_.reset(); // it has a workspace of its own
    }

    bool supernodal_;
    std::shared_ptr<const Symbolic> symbolic_; ///< null unless the factor is supernodal
    cholmod_factor own_factor_{}; ///< with the arrays of symbolic_
    cholmod_factor* factor_ = nullptr; ///< the one above, or one that CHOLMOD has made
    std::unique_ptr<SupernodalSolve<double>> own_; ///< solves for few columns
    std::int64_t nonzeros_ = 0;
};

} // namespace

bool have_cholmod() { return true; }

std::unique_ptr<FactorEngine> make_cholmod_factor(bool supernodal)
{
    return std::make_unique<CholmodFactor>(supernodal);
}

std::vector<int> cholmod_minimum_degree(const SparseMatrix& matrix)
{
    Workspace workspace;
    cholmod_sparse a = view(matrix);
    std::vector<int> order(matrix.cols());
    if (!cholmod_amd(&a, nullptr, 0, order.data(), workspace.get()))
        throw std::bad_alloc();
    return order;
}

std::vector<int> nested_dissection(const SparseMatrix& matrix)
{
    const std::lock_guard turn(random_numbers());
    Workspace workspace;
    cholmod_sparse a = view(matrix);
    std::vector<int> order(matrix.cols());
    if (!cholmod_metis(&a, nullptr, 0, true, order.data(), workspace.get()))
        throw InvalidOption("nested dissection needs a CHOLMOD with METIS; choose minimum_degree");
    return order;
}

std::vector<Side> bisection(const Graph& graph, const std::vector<int>& weights)
{
    const std::lock_guard turn(random_numbers());
    Workspace workspace;
    cholmod_sparse a = view(graph);
    std::vector<int> part(graph.size());
    if (cholmod_metis_bisector(&a, const_cast<int*>(weights.data()), nullptr, part.data(), workspace.get()) <
        0)
        throw std::bad_alloc();
    std::vector<Side> sides(graph.size());
    std::ranges::transform(part, sides.begin(), [](int p) { return static_cast<Side>(p); });
    return sides;
}

std::vector<int> constrained_minimum_degree(const Graph& graph, const std::vector<int>& sets)
{
    Workspace workspace;
    cholmod_sparse a = view(graph);
    a.stype = 1; // the lower triangle is not read
    std::vector<int> order(graph.size());
    if (!cholmod_camd(&a, nullptr, 0, const_cast<int*>(sets.data()), order.data(), workspace.get()))
        throw std::bad_alloc();
    return order;
}

} // namespace sinew

#else

namespace sinew {

bool have_cholmod() { return false; }
std::unique_ptr<FactorEngine> make_cholmod_factor(bool) { return nullptr; }
std::vector<int> cholmod_minimum_degree(const SparseMatrix&) { return {}; }
std::vector<int> nested_dissection(const SparseMatrix&)
{
    throw InvalidOption("nested dissection needs a build with CHOLMOD; choose minimum_degree");
}
std::vector<Side> bisection(const Graph&, const std::vector<int>&) { return {}; }
std::vector<int> constrained_minimum_degree(const Graph&, const std::vector<int>&) { return {}; }

} // namespace sinew

#endif
