// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/spd_factor.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/engines/ldlt_factor.h"
#include "native/solvers/shared_analyses.h"

#include <algorithm>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// A pivot below this share of its diagonal entry consists of rounding errors: the matrix is singular, or a
/// solution would have no correct digit. The pivots of a good operator of order k shrink as
/// (edge length / size)^2k, to 1e-12 for k = 2 and a million unknowns.
constexpr double rounding = 1e-14;

/// An update that costs more than this share of a factorisation is not done: a factorisation with a new
/// ordering leaves out the rows that are given now, so it is worth its cost.
constexpr double most_updated = 0.8;

std::unique_ptr<FactorEngine> make_engine(const FactorOptions& options)
{
    const FactorBackend backend = options.backend;
    if (backend == FactorBackend::ldlt)
        return make_ldlt_factor();
    if (!have_cholmod()) {
        if (backend != FactorBackend::automatic)
            throw InvalidOption("backend: this build has no CHOLMOD; choose automatic or ldlt");
        return make_ldlt_factor();
    }
    return make_cholmod_factor(backend != FactorBackend::simplicial);
}

[[noreturn]] void refuse(int unknown, const char* reason)
{
    throw FactorizationFailed(std::string("the matrix ") + reason + " at unknown " + std::to_string(unknown),
                              Error::Element::vertex, {unknown});
}

} // namespace

SpdFactor::SpdFactor(const FactorOptions& options) : options_(options) {}
SpdFactor::~SpdFactor() = default;
SpdFactor::SpdFactor(SpdFactor&&) noexcept = default;
SpdFactor& SpdFactor::operator=(SpdFactor&&) noexcept = default;

template <class Copy>
void SpdFactor::analyze(int size, std::uint64_t pattern, const Copy& copy)
{
    std::unique_ptr<FactorEngine> engine = make_engine(options_);
    const SharedAnalyses::Key key{pattern, size, options_.backend, options_.ordering};
    try {
        if (const std::shared_ptr<const Analysis> known = SharedAnalyses::find(key)) {
            engine->adopt(known);
        } else {
            const auto& matrix = copy(); // a copy is freed before the factor is computed
            engine->analyze(matrix, elimination_order(matrix, options_.ordering));
            SharedAnalyses::keep(key, engine->analysis());
        }
    } catch (const std::bad_alloc&) {
        throw OutOfMemory("memory ran out before the size of the factor was known: use fewer vertices");
    }
    require_memory(engine->bytes());
    engine_ = std::move(engine);
    size_ = size;
    pattern_ = pattern;
    ++analyses_;
}

template <class Matrix>
int SpdFactor::compute(const Matrix& matrix)
{
    valid_ = false;
    share_ = 1;
    try {
        return engine_->factorize(matrix);
    } catch (const std::bad_alloc&) {
        const std::string needed = in_words(engine_->bytes());
        engine_.reset();
        throw OutOfMemory("the factor needs " + needed +
                          ", more than is left on this machine: close other programs or use fewer vertices");
    }
}

void SpdFactor::clear()
{
    engine_.reset();
    size_ = 0;
}

void SpdFactor::factorize(const SparseMatrix& matrix)
{
    if (matrix.cols() == 0)
        return clear();
    const std::uint64_t pattern = digest(matrix);
    if (!engine_ || matrix.cols() != size_ || pattern != pattern_)
        analyze(static_cast<int>(matrix.cols()), pattern, [&]() -> const SparseMatrix& { return matrix; });
    const int broken = compute(matrix);
    check(matrix.diagonal(), broken);
}

void SpdFactor::factorize(const PrincipalBlock& block)
{
    if (block.size() == 0)
        return clear();
    const std::uint64_t pattern = block.digest();
    if (!engine_ || block.size() != size_ || pattern != pattern_)
        analyze(block.size(), pattern, [&] { return block.copy(); });
    const int broken = compute(block);
    check(block.diagonal(), broken);
}

bool SpdFactor::update(const PrincipalBlock& block, const std::vector<int>& changed)
{
    if (!valid_ || !engine_ || block.size() != size_ || block.digest() != pattern_)
        return false;
    require_memory(engine_->bytes());
    double share = 0;
    const std::optional<int> broken = engine_->update(block, changed, most_updated, share);
    if (!broken)
        return false;
    valid_ = false;
    share_ = share;
    check(block.diagonal(), *broken);
    return true;
}

void SpdFactor::check(const VectorX& diagonal, int broken)
{
    ++factorizations_;
    if (broken >= 0)
        refuse(broken, "is not positive definite; it broke down");
    const VectorX pivots = engine_->pivots();
    for (int i = 0; i < size_; ++i)
        if (!(pivots[i] > rounding * diagonal[i]))
            refuse(i, "is singular to working precision; it broke down");
    valid_ = true;
}

void SpdFactor::require_factor(Eigen::Index rows) const
{
    if (rows != size_)
        throw InvalidConstraint("right side: " + std::to_string(rows) + " rows for " + std::to_string(size_) +
                                " unknowns");
    if (!valid_ && size_ > 0)
        throw FactorizationFailed("there is no factor, as the last matrix could not be factorised");
}

MatrixX SpdFactor::solve(const MatrixX& rhs) const
{
    require_factor(rhs.rows());
    MatrixX solution(rhs.rows(), rhs.cols());
    if (rhs.size() > 0)
        engine_->solve(rhs, solution);
    return solution;
}

void SpdFactor::solve_rows(RowMatrix& x) const
{
    require_factor(x.rows());
    if (x.size() > 0)
        engine_->solve_rows(x);
}

std::int64_t SpdFactor::nonzeros() const { return engine_ ? engine_->nonzeros() : 0; }

std::int64_t SpdFactor::bytes() const { return engine_ ? engine_->bytes() : 0; }

} // namespace sinew
