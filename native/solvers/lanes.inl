// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of LaneKernels, compiled once for each instruction set. Only code of this file may be seen by a
// compiler that uses wider instructions: an inline function shared with other files could end up there, too.

namespace {

#ifdef __GNUC__
using Lanes = double __attribute__((vector_size(32), aligned(8)));
inline Lanes load(const double* from) { return *reinterpret_cast<const Lanes*>(from); }
inline void store(double* to, Lanes lanes) { *reinterpret_cast<Lanes*>(to) = lanes; }
#else
struct Lanes
{
    double lane[4];
};
inline Lanes load(const double* from) { return {{from[0], from[1], from[2], from[3]}}; }
inline void store(double* to, const Lanes& lanes)
{
    for (int k = 0; k < 4; ++k)
        to[k] = lanes.lane[k];
}
inline Lanes operator*(double factor, const Lanes& a)
{
    return {{factor * a.lane[0], factor * a.lane[1], factor * a.lane[2], factor * a.lane[3]}};
}
inline Lanes operator+(const Lanes& a, const Lanes& b)
{
    return {{a.lane[0] + b.lane[0], a.lane[1] + b.lane[1], a.lane[2] + b.lane[2], a.lane[3] + b.lane[3]}};
}
inline Lanes operator-(const Lanes& a, const Lanes& b)
{
    return {{a.lane[0] - b.lane[0], a.lane[1] - b.lane[1], a.lane[2] - b.lane[2], a.lane[3] - b.lane[3]}};
}
#endif

template <int width>
void subtract_columns(const double* block, int stride, int height, const double* points, double* rows)
{
    Lanes p[width];
    for (int c = 0; c < width; ++c)
        p[c] = load(points + 4 * c);
    for (int r = 0; r < height; ++r) {
        Lanes sum = block[r] * p[0];
        for (int c = 1; c < width; ++c)
            sum = sum + block[r + c * stride] * p[c];
        store(rows + 4 * r, load(rows + 4 * r) - sum);
    }
}

template <int width>
void subtract_dots(const double* block, int stride, int height, const double* rows, double* points)
{
    Lanes sum[width];
    for (int c = 0; c < width; ++c)
        sum[c] = load(points + 4 * c);
    for (int r = 0; r < height; ++r) {
        const Lanes row = load(rows + 4 * r);
        for (int c = 0; c < width; ++c)
            sum[c] = sum[c] - block[r + c * stride] * row;
    }
    for (int c = 0; c < width; ++c)
        store(points + 4 * c, sum[c]);
}

// Eight columns at a time: eight sums grow side by side, where one alone would wait for each addition.

void subtract_product(const double* block, int stride, int columns, int height, const double* points,
                      double* rows)
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

void subtract_transposed(const double* block, int stride, int columns, int height, const double* rows,
                         double* points)
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

void triangle(const double* block, int stride, int columns, const double* diagonal, double* points)
{
    for (int i = columns - 1; i >= 0; --i) {
        Lanes sum = diagonal[i] * load(points + 4 * i);
        for (int j = 0; j < i; ++j)
            sum = sum + block[j + i * stride] * load(points + 4 * j);
        store(points + 4 * i, sum);
    }
}

void triangle_transposed(const double* block, int stride, int columns, const double* diagonal, double* points)
{
    for (int i = 0; i < columns; ++i) {
        const Lanes point = load(points + 4 * i);
        for (int j = 0; j < i; ++j)
            store(points + 4 * j, load(points + 4 * j) + block[j + i * stride] * point);
        store(points + 4 * i, diagonal[i] * point);
    }
}

/// Eight rows in two vectors, three columns: six sums side by side.
void product_of_eight(const double* block, int columns, const double* factors, double* sums)
{
    Lanes sum[6], b[2];
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
