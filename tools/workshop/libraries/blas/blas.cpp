// SPDX-License-Identifier: GPL-3.0-or-later
// The names that Fortran's compilers give to the routines, for the widest instructions that the processor
// has.
#include "native/core/simd/processor.h"
#include "routines.h"

#include <cstdlib>

extern const Routines blas_baseline, blas_haswell, blas_skylake;

namespace {

const Routines& routines()
{
#ifdef SINEW_HAVE_WIDE_BLAS
    if (sinew::processor().avx512)
        return blas_skylake;
    if (sinew::processor().avx2 && sinew::processor().fma)
        return blas_haswell;
#endif
    return blas_baseline;
}

} // namespace

extern "C" {

void dgemm_(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
            const int* inner, const double* alpha, const double* a, const int* stride_a, const double* b,
            const int* stride_b, const double* beta, double* c, const int* stride_c)
{
    routines().dgemm(transpose_a, transpose_b, rows, columns, inner, alpha, a, stride_a, b, stride_b, beta, c,
                     stride_c);
}

void dsyrk_(const char* triangle, const char* transpose, const int* size, const int* inner,
            const double* alpha, const double* a, const int* stride_a, const double* beta, double* c,
            const int* stride_c)
{
    routines().dsyrk(triangle, transpose, size, inner, alpha, a, stride_a, beta, c, stride_c);
}

void dtrsm_(const char* side, const char* triangle, const char* transpose, const char* unit, const int* rows,
            const int* columns, const double* alpha, const double* a, const int* stride_a, double* b,
            const int* stride_b)
{
    routines().dtrsm(side, triangle, transpose, unit, rows, columns, alpha, a, stride_a, b, stride_b);
}

void dtrsv_(const char* triangle, const char* transpose, const char* unit, const int* size, const double* a,
            const int* stride, double* x, const int* step)
{
    if (*step != 1)
        std::abort();
    const int one = 1;
    const double alpha = 1;
    dtrsm_("L", triangle, transpose, unit, size, &one, &alpha, a, stride, x, size);
}

void dgemv_(const char* transpose, const int* rows, const int* columns, const double* alpha, const double* a,
            const int* stride_a, const double* x, const int* step_x, const double* beta, double* y,
            const int* step_y)
{
    routines().dgemv(transpose, rows, columns, alpha, a, stride_a, x, step_x, beta, y, step_y);
}

void dpotrf_(const char* triangle, const int* size, double* a, const int* stride, int* info)
{
    routines().dpotrf(triangle, size, a, stride, info);
}

// CHOLMOD names these for complex matrices, which Sinew does not have.
#define SINEW_NEVER(name)                                                                                    \
    void name() { std::abort(); }
SINEW_NEVER(zgemm_)
SINEW_NEVER(zgemv_)
SINEW_NEVER(zherk_)
SINEW_NEVER(zpotrf_)
SINEW_NEVER(ztrsm_)
SINEW_NEVER(ztrsv_)
}
