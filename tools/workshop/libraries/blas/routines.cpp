// SPDX-License-Identifier: GPL-3.0-or-later
#include "routines.h"

#include <Eigen/Dense>

#include <cstdlib>

namespace {

using Strides = Eigen::OuterStride<>;
using Block = Eigen::Map<Eigen::MatrixXd, 0, Strides>;
using ConstBlock = Eigen::Map<const Eigen::MatrixXd, 0, Strides>;
using Steps = Eigen::InnerStride<>;
using Entries = Eigen::Map<Eigen::VectorXd, 0, Steps>;
using ConstEntries = Eigen::Map<const Eigen::VectorXd, 0, Steps>;

/// Whether a letter of a BLAS call is this one; both cases mean the same.
bool is(const char* letter, char wanted) { return (*letter | 0x20) == wanted; }

/// Multiplies by a factor. Zero overwrites, also what is not a number.
template <typename Values>
void scale(Values&& values, double factor)
{
    if (factor == 0)
        values.setZero();
    else if (factor != 1)
        values *= factor;
}

void dgemm(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
           const int* inner, const double* alpha, const double* a, const int* stride_a, const double* b,
           const int* stride_b, const double* beta, double* c, const int* stride_c)
{
    const bool turn_a = !is(transpose_a, 'n'), turn_b = !is(transpose_b, 'n');
    const ConstBlock A(a, turn_a ? *inner : *rows, turn_a ? *rows : *inner, Strides(*stride_a));
    const ConstBlock B(b, turn_b ? *columns : *inner, turn_b ? *inner : *columns, Strides(*stride_b));
    Block C(c, *rows, *columns, Strides(*stride_c));
    scale(C, *beta);
    if (turn_a && turn_b)
        C.noalias() += *alpha * A.transpose() * B.transpose();
    else if (turn_a)
        C.noalias() += *alpha * A.transpose() * B;
    else if (turn_b)
        C.noalias() += *alpha * A * B.transpose();
    else
        C.noalias() += *alpha * A * B;
}

template <unsigned triangle>
void add_square(Block& C, const ConstBlock& A, bool turned, double alpha, double beta)
{
    for (Eigen::Index j = 0; j < C.cols(); ++j)
        scale(triangle == Eigen::Lower ? C.col(j).tail(C.rows() - j) : C.col(j).head(j + 1), beta);
    if (turned)
        C.selfadjointView<triangle>().rankUpdate(A.transpose(), alpha);
    else
        C.selfadjointView<triangle>().rankUpdate(A, alpha);
}

void dsyrk(const char* triangle, const char* transpose, const int* size, const int* inner,
           const double* alpha, const double* a, const int* stride_a, const double* beta, double* c,
           const int* stride_c)
{
    const bool turned = !is(transpose, 'n');
    const ConstBlock A(a, turned ? *inner : *size, turned ? *size : *inner, Strides(*stride_a));
    Block C(c, *size, *size, Strides(*stride_c));
    if (is(triangle, 'l'))
        add_square<Eigen::Lower>(C, A, turned, *alpha, *beta);
    else
        add_square<Eigen::Upper>(C, A, turned, *alpha, *beta);
}

void dtrsm(const char* side, const char* triangle, const char* transpose, const char* unit, const int* rows,
           const int* columns, const double* alpha, const double* a, const int* stride_a, double* b,
           const int* stride_b)
{
    if (is(unit, 'u'))
        std::abort();
    const bool left = is(side, 'l'), lower = is(triangle, 'l'), turned = !is(transpose, 'n');
    const int size = left ? *rows : *columns;
    const ConstBlock A(a, size, size, Strides(*stride_a));
    Block B(b, *rows, *columns, Strides(*stride_b));
    scale(B, *alpha);
    using namespace Eigen;
    if (left && lower && turned)
        A.transpose().triangularView<Upper>().solveInPlace(B);
    else if (left && lower)
        A.triangularView<Lower>().solveInPlace(B);
    else if (left && turned)
        A.transpose().triangularView<Lower>().solveInPlace(B);
    else if (left)
        A.triangularView<Upper>().solveInPlace(B);
    else if (lower && turned)
        A.transpose().triangularView<Upper>().solveInPlace<OnTheRight>(B);
    else if (lower)
        A.triangularView<Lower>().solveInPlace<OnTheRight>(B);
    else if (turned)
        A.transpose().triangularView<Lower>().solveInPlace<OnTheRight>(B);
    else
        A.triangularView<Upper>().solveInPlace<OnTheRight>(B);
}

void dgemv(const char* transpose, const int* rows, const int* columns, const double* alpha, const double* a,
           const int* stride_a, const double* x, const int* step_x, const double* beta, double* y,
           const int* step_y)
{
    const bool turned = !is(transpose, 'n');
    const ConstBlock A(a, *rows, *columns, Strides(*stride_a));
    const ConstEntries from(x, turned ? *rows : *columns, Steps(*step_x));
    Entries to(y, turned ? *columns : *rows, Steps(*step_y));
    scale(to, *beta);
    if (turned)
        to.noalias() += *alpha * A.transpose() * from;
    else
        to.noalias() += *alpha * A * from;
}

void dpotrf(const char* triangle, const int* size, double* a, const int* stride, int* info)
{
    if (!is(triangle, 'l'))
        std::abort();
    Block A(a, *size, *size, Strides(*stride));
    // -1, or the first column whose pivot is not positive; LAPACK counts from one.
    *info = static_cast<int>(Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(A)) + 1;
}

} // namespace

extern const Routines SINEW_BLAS;
const Routines SINEW_BLAS{dgemm, dsyrk, dtrsm, dgemv, dpotrf};
