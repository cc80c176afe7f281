// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/cholmod_factor.h"

#include "native/core/errors.h"
#include "native/solvers/lanes.h"
#include "native/solvers/supernodal_solve.h"

#ifdef SINEW_HAVE_CHOLMOD

#include <cholmod.h>
#ifdef SINEW_HAVE_OPENMP
#include <omp.h>
#endif
#ifdef __GNUC__
// Absent unless the BLAS is OpenBLAS.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));
extern "C" int openblas_get_parallel() __attribute__((weak));
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <new>
#include <numeric>
#include <string>

namespace sinew {

namespace {

enum class Blas { unknown, serial, pthread, openmp };

Blas blas()
{
#ifdef __GNUC__
    if (openblas_get_parallel)
        return std::array{Blas::serial, Blas::pthread, Blas::openmp}[openblas_get_parallel() % 3];
#endif
    return Blas::unknown;
}

/// CHOLMOD opens OpenMP loops of its own whose spinning threads slow every later loop on a
/// small machine by up to ten times, and a BLAS of several threads gains nothing at these
/// block sizes. Both are held to one thread while a call runs. OpenBLAS' serial build is not
/// safe from two threads, so its calls queue; its OpenMP build hangs without active levels.
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
#ifdef __GNUC__
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

/// cholmod_common is workspace, not state: each call has its own, so solves may overlap.
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

/// A view of the matrix, lower triangle; CHOLMOD reads it and never writes.
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

class CholmodFactor final : public FactorEngine
{
public:
    explicit CholmodFactor(bool supernodal) : supernodal_(supernodal) {}
    ~CholmodFactor() override { release(); }

    void analyze(const SparseMatrix& matrix, const std::vector<int>& order) override
    {
        release();
        Workspace workspace;
        workspace.get()->supernodal = supernodal_ ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
        cholmod_sparse a = view(matrix);
        std::vector<int> permutation = order;
        factor_ = cholmod_analyze_p(&a, permutation.data(), nullptr, 0, workspace.get());
        if (!factor_)
            refuse(workspace.get()->status);
    }

    int factorize(const SparseMatrix& matrix) override
    {
        own_.reset();
        Workspace workspace;
        workspace.get()->supernodal = supernodal_ ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
        cholmod_sparse a = view(matrix);
        cholmod_factorize(&a, factor_, workspace.get());
        if (workspace.get()->status == CHOLMOD_NOT_POSDEF)
            return static_cast<const int*>(factor_->Perm)[std::min(factor_->minor, factor_->n - 1)];
        if (workspace.get()->status != CHOLMOD_OK)
            refuse(workspace.get()->status);
        nonzeros_ = count_entries();
        if (factor_->is_super) {
            view_ = {
                .size = static_cast<int>(factor_->n),
                .supernodes = static_cast<int>(factor_->nsuper),
                .permutation = static_cast<const int*>(factor_->Perm),
                .first = static_cast<const int*>(factor_->super),
                .row_begin = static_cast<const int*>(factor_->pi),
                .block_begin = static_cast<const int*>(factor_->px),
                .rows = static_cast<const int*>(factor_->s),
                .values = static_cast<double*>(factor_->x),
            };
            own_ = std::make_unique<SupernodalSolve<double>>(view_);
        }
        return -1;
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

    const SupernodalFactor<double>* supernodal() const override { return own_ ? &view_ : nullptr; }

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
        if (status == CHOLMOD_TOO_LARGE)
            throw OutOfMemory("the factor has more entries than can be addressed: use fewer vertices");
        throw FactorizationFailed("CHOLMOD failed with status " + std::to_string(status));
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
        if (factor_) {
            own_.reset();
            Workspace workspace;
            cholmod_free_factor(&factor_, workspace.get());
        }
    }

    bool supernodal_;
    cholmod_factor* factor_ = nullptr;
    SupernodalFactor<double> view_;
    std::unique_ptr<SupernodalSolve<double>> own_; ///< faster than CHOLMOD's up to four columns
    std::int64_t nonzeros_ = 0;
};

} // namespace

bool have_cholmod() { return true; }

std::unique_ptr<FactorEngine> make_cholmod_factor(bool supernodal)
{
    return std::make_unique<CholmodFactor>(supernodal);
}

std::vector<int> nested_dissection(const SparseMatrix& matrix)
{
    Workspace workspace;
    cholmod_sparse a = view(matrix);
    std::vector<int> order(matrix.cols());
    if (!cholmod_metis(&a, nullptr, 0, true, order.data(), workspace.get()))
        throw InvalidOption("nested dissection needs a CHOLMOD with METIS; choose minimum_degree");
    return order;
}

} // namespace sinew

#else

namespace sinew {

bool have_cholmod() { return false; }
std::unique_ptr<FactorEngine> make_cholmod_factor(bool) { return nullptr; }
std::vector<int> nested_dissection(const SparseMatrix&)
{
    throw InvalidOption("nested dissection needs a build with CHOLMOD; choose minimum_degree");
}

} // namespace sinew

#endif
