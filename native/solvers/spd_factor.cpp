// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/spd_factor.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/solvers/cholmod_factor.h"
#include "native/solvers/ldlt_factor.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// A pivot below this share of its diagonal entry is rounding: the matrix is singular, or a
/// solution would have no correct digit. Honest pivots shrink with the order k of an operator as
/// (edge length / size)^2k and reach 1e-12 for k = 2 at a million unknowns.
constexpr double rounding = 1e-14;

std::unique_ptr<FactorEngine> make_engine(const FactorOptions& options, const SparseMatrix& matrix)
{
    const FactorBackend backend = options.backend;
    if (backend == FactorBackend::ldlt)
        return make_ldlt_factor();
    if (!have_cholmod()) {
        if (backend != FactorBackend::automatic)
            throw InvalidOption("backend: this build has no CHOLMOD; choose automatic or ldlt");
        return make_ldlt_factor();
    }
    if (backend != FactorBackend::automatic)
        return make_cholmod_factor(backend == FactorBackend::supernodal);
    const bool second_ring = matrix.nonZeros() >= 12 * matrix.cols();
    return make_cholmod_factor(second_ring || matrix.cols() > (options.many_solves ? 250000 : 60000));
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

bool SpdFactor::same_pattern(const SparseMatrix& matrix) const
{
    return engine_ && matrix.cols() == size_ &&
           matrix.nonZeros() == static_cast<Eigen::Index>(rows_.size()) &&
           std::equal(offsets_.begin(), offsets_.end(), matrix.outerIndexPtr()) &&
           std::equal(rows_.begin(), rows_.end(), matrix.innerIndexPtr());
}

void SpdFactor::analyze(const SparseMatrix& matrix)
{
    std::unique_ptr<FactorEngine> engine = make_engine(options_, matrix);
    try {
        engine->analyze(matrix, elimination_order(matrix, options_.ordering));
    } catch (const std::bad_alloc&) {
        throw OutOfMemory("memory ran out before the size of the factor was known: use fewer vertices");
    }
    require_memory(engine->bytes());
    engine_ = std::move(engine);
    size_ = static_cast<int>(matrix.cols());
    offsets_.assign(matrix.outerIndexPtr(), matrix.outerIndexPtr() + size_ + 1);
    rows_.assign(matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
    ++analyses_;
}

void SpdFactor::factorize(const SparseMatrix& matrix)
{
    if (matrix.cols() == 0) {
        engine_.reset();
        size_ = 0;
        return;
    }
    if (!same_pattern(matrix))
        analyze(matrix);
    stands_ = false;
    int broken = -1;
    try {
        broken = engine_->factorize(matrix);
    } catch (const std::bad_alloc&) {
        const std::string needed = in_words(engine_->bytes());
        engine_.reset();
        throw OutOfMemory("the factor needs " + needed +
                          ", more than is left on this machine: close other programs or use fewer vertices");
    }
    ++factorizations_;
    if (broken >= 0)
        refuse(broken, "is not positive definite; it broke down");
    const VectorX pivots = engine_->pivots();
    const VectorX diagonal = matrix.diagonal();
    for (int i = 0; i < size_; ++i)
        if (!(pivots[i] > rounding * diagonal[i]))
            refuse(i, "is singular to working precision; it broke down");
    stands_ = true;
}

MatrixX SpdFactor::solve(const MatrixX& rhs) const
{
    if (rhs.rows() != size_)
        throw InvalidConstraint("right side: " + std::to_string(rhs.rows()) + " rows for " +
                                std::to_string(size_) + " unknowns");
    MatrixX solution(rhs.rows(), rhs.cols());
    if (rhs.size() == 0)
        return solution;
    if (!stands_)
        throw FactorizationFailed("there is no factor: the last matrix was refused");
    engine_->solve(rhs, solution);
    return solution;
}

std::int64_t SpdFactor::nonzeros() const { return engine_ ? engine_->nonzeros() : 0; }

std::int64_t SpdFactor::bytes() const { return engine_ ? engine_->bytes() : 0; }

} // namespace sinew
