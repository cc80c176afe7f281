// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of LaneKernels, compiled once for each instruction set. Only code of this file may be seen by a
// compiler that uses wider instructions: an inline function shared with other files could end up there, too.

#include "native/core/lane_types.inl"

namespace {

template <int width, class T>
void subtract_columns(const T* block, int stride, int height, const T* points, T* rows)
{
    Lanes<T> p[width];
    for (int c = 0; c < width; ++c)
        p[c] = load(points + 4 * c);
    for (int r = 0; r < height; ++r) {
        Lanes<T> sum = block[r] * p[0];
        for (int c = 1; c < width; ++c)
            sum = sum + block[r + c * stride] * p[c];
        store(rows + 4 * r, load(rows + 4 * r) - sum);
    }
}

template <int width, class T>
void subtract_dots(const T* block, int stride, int height, const T* rows, T* points)
{
    Lanes<T> sum[width];
    for (int c = 0; c < width; ++c)
        sum[c] = load(points + 4 * c);
    for (int r = 0; r < height; ++r) {
        const Lanes<T> row = load(rows + 4 * r);
        for (int c = 0; c < width; ++c)
            sum[c] = sum[c] - block[r + c * stride] * row;
    }
    for (int c = 0; c < width; ++c)
        store(points + 4 * c, sum[c]);
}

// Eight columns at a time: eight sums grow side by side, where one alone would wait for each addition.

template <class T>
void subtract_product(const T* block, int stride, int columns, int height, const T* points, T* rows)
{
    for (; columns >= 8; columns -= 8, block += 8 * stride, points += 32)
        subtract_columns<8>(block, stride, height, points, rows);
    if (columns >= 4) {
        subtract_columns<4>(block, stride, height, points, rows);
        columns -= 4, block += 4 * stride, points += 16;
    }
    if (columns == 3)
        subtract_columns<3>(block, stride, height, points, rows);
    else if (columns == 2)
        subtract_columns<2>(block, stride, height, points, rows);
    else if (columns == 1)
        subtract_columns<1>(block, stride, height, points, rows);
}

template <class T>
void subtract_transposed(const T* block, int stride, int columns, int height, const T* rows, T* points)
{
    for (; columns >= 8; columns -= 8, block += 8 * stride, points += 32)
        subtract_dots<8>(block, stride, height, rows, points);
    if (columns >= 4) {
        subtract_dots<4>(block, stride, height, rows, points);
        columns -= 4, block += 4 * stride, points += 16;
    }
    if (columns == 3)
        subtract_dots<3>(block, stride, height, rows, points);
    else if (columns == 2)
        subtract_dots<2>(block, stride, height, rows, points);
    else if (columns == 1)
        subtract_dots<1>(block, stride, height, rows, points);
}

template <class T>
void triangle(const T* block, int stride, int columns, const T* diagonal, T* points)
{
    for (int i = columns - 1; i >= 0; --i) {
        Lanes<T> sum = diagonal[i] * load(points + 4 * i);
        for (int j = 0; j < i; ++j)
            sum = sum + block[j + i * stride] * load(points + 4 * j);
        store(points + 4 * i, sum);
    }
}

template <class T>
void triangle_transposed(const T* block, int stride, int columns, const T* diagonal, T* points)
{
    for (int i = 0; i < columns; ++i) {
        const Lanes<T> point = load(points + 4 * i);
        for (int j = 0; j < i; ++j)
            store(points + 4 * j, load(points + 4 * j) + block[j + i * stride] * point);
        store(points + 4 * i, diagonal[i] * point);
    }
}

/// Eight rows in two vectors, three columns: six sums side by side.
template <class T>
void product_of_eight(const T* block, int columns, const T* factors, T* sums)
{
    Lanes<T> sum[6], b[2];
    for (int k = 0; k < 6; ++k)
        sum[k] = load(block + 4 * k);
    block += 24;
    for (int c = 0; c < columns; ++c, block += 8, factors += 3) {
        b[0] = load(block);
        b[1] = load(block + 4);
        for (int k = 0; k < 6; ++k)
            sum[k] = sum[k] + factors[k / 2] * b[k % 2];
    }
    for (int k = 0; k < 6; ++k)
        store(sums + 4 * k, sum[k]);
}

} // namespace
