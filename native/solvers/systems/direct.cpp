// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/systems/direct.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/solvers/sparse_columns.h"
#include "native/solvers/spd_factor.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <Eigen/SparseLU>

#include <memory>
#include <string>
#include <utility>

namespace sinew {

namespace {

using Solve = std::function<RowMatrix(const RowMatrix&)>;

/// A matrix whose condition is worse than the inverse of this has solutions without one correct digit.
constexpr double singular = 1e-15;

[[noreturn]] void refuse_singular() { throw FactorizationFailed("the matrix is singular"); }

template <class Factor>
Solve keep(std::shared_ptr<Factor> factor)
{
    return [factor = std::move(factor)](const RowMatrix& b) {
        const MatrixX by_columns = b, x = factor->solve(by_columns);
        return RowMatrix(x);
    };
}

Solve dense(const MatrixX& A, Solver solver)
{
    switch (solver) {
    case Solver::dense_cholesky: {
        auto factor = std::make_shared<Eigen::LLT<MatrixX>>(A);
        if (factor->info() != Eigen::Success)
            throw FactorizationFailed("the matrix is not positive definite; choose dense_lu");
        if (!(factor->rcond() > singular))
            refuse_singular();
        return keep(std::move(factor));
    }
    case Solver::dense_lu: {
        auto factor = std::make_shared<Eigen::PartialPivLU<MatrixX>>(A);
        if (!(factor->rcond() > singular))
            refuse_singular();
        return keep(std::move(factor));
    }
    case Solver::dense_qr: {
        auto factor = std::make_shared<Eigen::ColPivHouseholderQR<MatrixX>>(A);
        const VectorX pivots = factor->matrixQR().diagonal().cwiseAbs();
        if (!(pivots.minCoeff() > singular * pivots.maxCoeff()))
            refuse_singular();
        return keep(std::move(factor));
    }
    default: {
        auto factor = std::make_shared<Eigen::BDCSVD<MatrixX>>(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
        const VectorX& values = factor->singularValues();
        if (!(values.minCoeff() > singular * values.maxCoeff()))
            refuse_singular();
        return keep(std::move(factor));
    }
    }
}

Solve sparse_lu(const SparseMatrix& A, DirectNumbers& numbers)
{
    using Factor = Eigen::SparseLU<SparseMatrix, Eigen::COLAMDOrdering<int>>;
    auto factor = std::make_shared<Factor>();
    factor->compute(A);
    if (factor->info() != Eigen::Success)
        refuse_singular();
    numbers.entries = factor->nnzL() + factor->nnzU();
    numbers.bytes = numbers.entries * static_cast<std::int64_t>(sizeof(double) + sizeof(int));
    return keep(std::move(factor));
}

} // namespace

Solve factorized(const SparseMatrix& A, Solver solver, std::vector<int> order, DirectNumbers& numbers)
{
    if (solver == Solver::lu)
        return sparse_lu(A, numbers);
    if (solver != Solver::cholesky && solver != Solver::simplicial) {
        numbers.entries = A.rows() * A.cols();
        numbers.bytes = numbers.entries * static_cast<std::int64_t>(sizeof(double));
        require_memory(numbers.bytes, "the dense matrix");
        return dense(MatrixX(A), solver);
    }
    const FactorBackend backend =
        solver == Solver::cholesky ? FactorBackend::automatic : FactorBackend::simplicial;
    auto factor =
        std::make_shared<SpdFactor>(FactorOptions{.backend = backend, .ordering = Ordering::natural});
    std::vector<int> places(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        places[order[k]] = static_cast<int>(k);
    try {
        factor->factorize(sparse_by_columns(static_cast<int>(A.rows()), static_cast<int>(A.cols()),
                                            [&](int c, SparseColumn& column) {
                                                for (SparseMatrix::InnerIterator it(A, order[c]); it; ++it)
                                                    column.add(places[it.row()], it.value());
                                            }));
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& error) {
        if (error.elements().empty())
            throw;
        const int unknown = order[error.elements().front()];
        throw FactorizationFailed("the matrix is singular or not positive definite at unknown " +
                                      std::to_string(unknown),
                                  Error::Element::vertex, {unknown});
    }
    numbers = {factor->nonzeros(), factor->bytes()};
    return [factor = std::move(factor), order = std::move(order)](const RowMatrix& b) {
        RowMatrix x = b(order, Eigen::all), result(b.rows(), b.cols());
        factor->solve_rows(x);
        result(order, Eigen::all) = x;
        return result;
    };
}

} // namespace sinew
