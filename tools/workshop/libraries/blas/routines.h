// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Routines of BLAS and LAPACK for matrices of doubles, stored by columns, with sizes of 32 bits. They take
/// the arguments of the routines of these names. What neither CHOLMOD nor Sinew asks for ends the program: a
/// unit diagonal, a stride of vectors in dtrsv, an upper triangle in dpotrf.
struct Routines
{
    void (*dgemm)(const char* transpose_a, const char* transpose_b, const int* rows, const int* columns,
                  const int* inner, const double* alpha, const double* a, const int* stride_a,
                  const double* b, const int* stride_b, const double* beta, double* c, const int* stride_c);
    void (*dsyrk)(const char* triangle, const char* transpose, const int* size, const int* inner,
                  const double* alpha, const double* a, const int* stride_a, const double* beta, double* c,
                  const int* stride_c);
    void (*dtrsm)(const char* side, const char* triangle, const char* transpose, const char* unit,
                  const int* rows, const int* columns, const double* alpha, const double* a,
                  const int* stride_a, double* b, const int* stride_b);
    void (*dgemv)(const char* transpose, const int* rows, const int* columns, const double* alpha,
                  const double* a, const int* stride_a, const double* x, const int* step_x,
                  const double* beta, double* y, const int* step_y);
    void (*dpotrf)(const char* triangle, const int* size, double* a, const int* stride, int* info);
};
