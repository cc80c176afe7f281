// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace sinew {

/// Four columns of numbers side by side, a row for each unknown.
using Columns = std::vector<Eigen::Array4d>;
/// z = B r for a symmetric positive definite B that is close to A^-1. It may differ a little from call to call.
using Preconditioner = std::function<void(const Columns& r, Columns& z)>;

/// y = A x on the unknowns.
using Product = std::function<void(const Columns& x, Columns& y)>;

/// What an iteration compares with its tolerance. B r is an estimate of the error where B is very close to A^-1.
enum class Measure {
    residual,  ///< r = b - A x with b
    error,     ///< B r with x
    remaining, ///< B r of all columns with the largest x of all, and with all steps to come, which shrink as
    ///< those before did; x ends with the last B r added
    corrected, ///< the same, and what is left after that addition counts: a share of B r where others left little
};

/// When an iteration ends.
struct Stop
{
    double tolerance = 1e-8;
    int most_iterations = 0;
    Measure measure = Measure::residual;
};

/// What the iteration of four columns came to.
struct Iteration
{
    int count = 0;
    double reached = 0.0; ///< what the tolerance is compared with, of the worst column
    bool converged = false;
    double least = 0.0, most = 0.0; ///< eigenvalues of B A, from the coefficients of the worst column
};

/// The method of conjugate gradients, M. R. Hestenes, E. Stiefel 1952, with Lanczos' estimates of eigenvalues and the
/// flexible beta of Polak and Ribière. Each column has coefficients of its own.
/// \param x  what it begins from, and the solution. Columns of b that are 0 give 0.
/// \throw FactorizationFailed  A or B is not positive definite, or A is singular.
/// \throw NotConverged  the numbers are no longer finite, or grow without end.
/// \throw Cancelled
Iteration conjugate_gradients(const SparseMatrix& A, const Columns& b, Columns& x, const Preconditioner& B,
                              const Stop& stop, const Progress& progress);

/// The same for an A that is no matrix. Rows of x and r after the unknowns are left alone; those that A and B are given
/// are 0.
/// \param load  |b| of each column; those that are 0 are not solved for.
/// \param r     b - A x on the unknowns at first; what the iteration makes of it afterwards.
Iteration conjugate_gradients(int unknowns, const Product& A, const Eigen::Array4d& load, Columns& r,
                              Columns& x, const Preconditioner& B, const Stop& stop,
                              const Progress& progress);

/// The largest singular value of a linear map of one column, by `steps` steps of Lanczos' method with
/// reorthogonalisation from a random vector; a lower bound that is close.
double norm_of(int size, const std::function<VectorX(const VectorX&)>& map, int steps = 16);

} // namespace sinew
