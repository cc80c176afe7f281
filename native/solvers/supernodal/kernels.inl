// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of LaneKernels, compiled once for each set of instructions. Nothing else may be compiled with
// wider instructions: the linker could take an inline function from here for other files, too.

#include "native/core/simd/lane_types.inl"

namespace {

using sinew::LaneSupernode;

// A supernode's own points are stored one after the other, with x, y, z and an unused number. The rows below
// are stored in blocks of eight: first the x of all eight, then their y, and so on. A vector then has one
// coordinate of several rows, which are neighbours in the factor, too, and no lane is unused.

constexpr int eight = 8;

#ifdef __GNUC__
template <class T>
using Wide = typename LanesOf<T, 32 / sizeof(T)>::type; ///< one coordinate of several of the eight rows
template <class T>
inline Wide<T> load_wide(const T* from)
{
    return load_as<Wide<T>>(from);
}
template <class T>
inline void store_wide(T* to, Wide<T> rows)
{
    store(to, rows);
}
inline Lanes<double> folded(Wide<double> a) { return a; }
inline Lanes<float> folded(Wide<float> a)
{
    return __builtin_shufflevector(a, a, 0, 1, 2, 3) + __builtin_shufflevector(a, a, 4, 5, 6, 7);
}
inline void transpose(Lanes<float>& a, Lanes<float>& b, Lanes<float>& c, Lanes<float>& d)
{
    const Lanes<float> ab01 = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    const Lanes<float> ab23 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Lanes<float> cd01 = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const Lanes<float> cd23 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    a = __builtin_shufflevector(ab01, cd01, 0, 1, 4, 5);
    b = __builtin_shufflevector(ab01, cd01, 2, 3, 6, 7);
    c = __builtin_shufflevector(ab23, cd23, 0, 1, 4, 5);
    d = __builtin_shufflevector(ab23, cd23, 2, 3, 6, 7);
}
#else
template <class T>
using Wide = Lanes<T>;
template <class T>
inline Wide<T> load_wide(const T* from)
{
    return load(from);
}
template <class T>
inline void store_wide(T* to, const Wide<T>& rows)
{
    store(to, rows);
}
template <class T>
inline Lanes<T> folded(const Wide<T>& a)
{
    return a;
}
inline void transpose(Lanes<float>& a, Lanes<float>& b, Lanes<float>& c, Lanes<float>& d)
{
    const Lanes<float> m[4] = {a, b, c, d};
    a = {{m[0][0], m[1][0], m[2][0], m[3][0]}};
    b = {{m[0][1], m[1][1], m[2][1], m[3][1]}};
    c = {{m[0][2], m[1][2], m[2][2], m[3][2]}};
    d = {{m[0][3], m[1][3], m[2][3], m[3][3]}};
}
#endif
template <class T>
constexpr int wide = sizeof(Wide<T>) / sizeof(T);

inline int least(int a, int b) { return a < b ? a : b; }
inline int in_eights(int rows) { return (rows + eight - 1) / eight * eight; }

template <class T>
inline void clear(T* numbers, std::ptrdiff_t count)
{
    for (std::ptrdiff_t k = 0; k < count; ++k)
        numbers[k] = T(0);
}

/// How many numbers ahead to fetch into the second-level cache: one block of columns, within bounds. A
/// processor does not foresee these reads, as they come from many columns at once, or from short blocks.
template <class T>
inline std::ptrdiff_t fetched_ahead(int height)
{
    constexpr int fewest = 2048, most = 1 << 16;
    const std::ptrdiff_t block = static_cast<std::ptrdiff_t>(LaneSupernode<T>::triangle_width) * height;
    return block < fewest ? fewest : block < most ? block : most;
}
inline void fetch([[maybe_unused]] const void* from)
{
#ifdef __GNUC__
    __builtin_prefetch(from, 0, 2);
#endif
}

/// rows -= L points
template <int lanes, class T>
inline void subtract_product(const T* L, std::ptrdiff_t stride, int columns, int height, const T* points,
                             T* rows, std::ptrdiff_t ahead)
{
    constexpr int parts = eight / wide<T>;
    for (int r = 0; r < height; r += eight, rows += eight * lanes) {
        Wide<T> sum[lanes][parts];
        for (int k = 0; k < lanes; ++k)
            for (int p = 0; p < parts; ++p)
                sum[k][p] = load_wide(rows + eight * k + wide<T> * p);
        const T* l = L + r;
        for (int c = 0; c < columns; ++c, l += stride) {
            fetch(l + ahead);
            for (int p = 0; p < parts; ++p) {
                const Wide<T> column = load_wide(l + wide<T> * p);
                for (int k = 0; k < lanes; ++k)
                    sum[k][p] = sum[k][p] - points[4 * c + k] * column;
            }
        }
        for (int k = 0; k < lanes; ++k)
            for (int p = 0; p < parts; ++p)
                store_wide(rows + eight * k + wide<T> * p, sum[k][p]);
    }
}

/// points -= L^T rows for a few columns. Each column has its own vector of sums, which is added up at the
/// end.
template <int lanes, int columns, class T>
inline void subtract_dots(const T* L, std::ptrdiff_t stride, int height, const T* rows, T* points,
                          std::ptrdiff_t ahead)
{
    Wide<T> sum[columns][lanes] = {};
    for (int r = 0; r < height; r += eight, rows += eight * lanes)
        for (int part = 0; part < eight; part += wide<T>) {
            Wide<T> row[lanes];
            for (int k = 0; k < lanes; ++k)
                row[k] = load_wide(rows + eight * k + part);
            for (int c = 0; c < columns; ++c) {
                if (part == 0)
                    fetch(L + c * stride + r - ahead);
                const Wide<T> column = load_wide(L + c * stride + r + part);
                for (int k = 0; k < lanes; ++k)
                    sum[c][k] = sum[c][k] + column * row[k];
            }
        }
    Lanes<T> point[4] = {};
    for (int k = 0; k < lanes; ++k) {
        Lanes<T> across[4]; // only the first `columns` are used
        for (int c = 0; c < 4; ++c)
            across[c] = folded(sum[least(c, columns - 1)][k]);
        transpose(across[0], across[1], across[2], across[3]);
        point[k] = (across[0] + across[1]) + (across[2] + across[3]);
    }
    transpose(point[0], point[1], point[2], point[3]);
    for (int c = 0; c < columns; ++c)
        store(points + 4 * c, load(points + 4 * c) - point[c]);
}

/// points -= L^T rows, from the last column to the first; `rows` is zero past `height`.
template <int lanes, class T>
inline void subtract_transposed(const T* L, std::ptrdiff_t stride, int columns, int height, const T* rows,
                                T* points, std::ptrdiff_t ahead)
{
    constexpr int together = lanes == 3 ? 4 : 2; // so many columns that their sums stay in registers
    int first = columns / together * together;
    switch (columns - first) {
    case 3:
        subtract_dots<lanes, 3>(L + first * stride, stride, height, rows, points + 4 * first, ahead);
        break;
    case 2:
        subtract_dots<lanes, 2>(L + first * stride, stride, height, rows, points + 4 * first, ahead);
        break;
    case 1:
        subtract_dots<lanes, 1>(L + first * stride, stride, height, rows, points + 4 * first, ahead);
        break;
    }
    while (first > 0) {
        first -= together;
        subtract_dots<lanes, together>(L + first * stride, stride, height, rows, points + 4 * first, ahead);
    }
}

// Products with the inverse of a triangle, for `count` rows at a time, whose sums do not wait for each other.

template <int count, class T>
inline void triangle_rows(const T* block, std::ptrdiff_t stride, int first, const T* diagonal, T* points)
{
    Lanes<T> own[count], sum[count];
    for (int k = 0; k < count; ++k) {
        own[k] = load(points + 4 * (first + k));
        sum[k] = diagonal[first + k] * own[k];
        for (int j = 0; j < k; ++j)
            sum[k] = sum[k] + block[first + j + (first + k) * stride] * own[j];
    }
    for (int j = 0; j < first; ++j) {
        const Lanes<T> point = load(points + 4 * j);
        for (int k = 0; k < count; ++k)
            sum[k] = sum[k] + block[j + (first + k) * stride] * point;
    }
    for (int k = 0; k < count; ++k)
        store(points + 4 * (first + k), sum[k]);
}

template <int count, class T>
inline void triangle_columns(const T* block, std::ptrdiff_t stride, int first, int columns, const T* diagonal,
                             T* points)
{
    Lanes<T> own[count], sum[count];
    for (int k = 0; k < count; ++k)
        own[k] = load(points + 4 * (first + k));
    for (int k = 0; k < count; ++k) {
        sum[k] = diagonal[first + k] * own[k];
        for (int i = k + 1; i < count; ++i)
            sum[k] = sum[k] + block[first + k + (first + i) * stride] * own[i];
    }
    for (int i = first + count; i < columns; ++i) {
        const Lanes<T> point = load(points + 4 * i);
        for (int k = 0; k < count; ++k)
            sum[k] = sum[k] + block[first + k + i * stride] * point;
    }
    for (int k = 0; k < count; ++k)
        store(points + 4 * (first + k), sum[k]);
}

/// points = T points, where T is the inverse of the triangle of a block
template <class T>
inline void triangle(const T* block, std::ptrdiff_t stride, int columns, const T* diagonal, T* points)
{
    int first = columns / 4 * 4;
    switch (columns - first) {
    case 3:
        triangle_rows<3>(block, stride, first, diagonal, points);
        break;
    case 2:
        triangle_rows<2>(block, stride, first, diagonal, points);
        break;
    case 1:
        triangle_rows<1>(block, stride, first, diagonal, points);
        break;
    }
    while (first > 0)
        triangle_rows<4>(block, stride, first -= 4, diagonal, points);
}

/// points = T^T points, with the same T
template <class T>
inline void triangle_transposed(const T* block, std::ptrdiff_t stride, int columns, const T* diagonal,
                                T* points)
{
    int first = 0;
    for (; first + 4 <= columns; first += 4)
        triangle_columns<4>(block, stride, first, columns, diagonal, points);
    switch (columns - first) {
    case 3:
        triangle_columns<3>(block, stride, first, columns, diagonal, points);
        break;
    case 2:
        triangle_columns<2>(block, stride, first, columns, diagonal, points);
        break;
    case 1:
        triangle_columns<1>(block, stride, first, columns, diagonal, points);
        break;
    }
}

/// Four rows, from blocks of eight to points. The fourth lane is zero if there are three lanes.
template <int lanes, class T>
inline void to_points(const T* rows, int r, Lanes<T> (&point)[4])
{
    const T* block = rows + static_cast<std::ptrdiff_t>(r / eight) * (eight * lanes) + r % eight;
    for (int k = 0; k < 4; ++k)
        point[k] = k < lanes ? load(block + eight * k) : Lanes<T>{};
    transpose(point[0], point[1], point[2], point[3]);
}

template <int lanes, class T>
inline void from_points(Lanes<T> (&point)[4], T* rows, int r)
{
    T* block = rows + static_cast<std::ptrdiff_t>(r / eight) * (eight * lanes) + r % eight;
    transpose(point[0], point[1], point[2], point[3]);
    for (int k = 0; k < lanes; ++k)
        store(block + eight * k, point[k]);
}

template <int lanes, class T>
inline void forward(const LaneSupernode<T>& s, T* own, T* points, int inside, T* sums, const int* place,
                    T* workspace)
{
    constexpr int width = LaneSupernode<T>::triangle_width;
    const int rest = s.height - s.width;
    const std::ptrdiff_t ahead = fetched_ahead<T>(s.height);
    T* const below = workspace;
    T* const beside =
        below + static_cast<std::ptrdiff_t>(in_eights(rest)) * lanes; // for its own later columns
    clear(below,
          static_cast<std::ptrdiff_t>(in_eights(rest) + (s.width > width ? in_eights(s.width) : 0)) * lanes);
    Lanes<T> point[4];
    for (int c = 0; c < s.width; c += width) {
        const int part = least(width, s.width - c);
        const T* const L = s.values + static_cast<std::ptrdiff_t>(c) * s.height;
        if (c > 0)
            for (int r = c; r < c + part; r += 4) {
                to_points<lanes>(beside, r, point);
                for (int k = 0; k < least(4, c + part - r); ++k)
                    store(own + 4 * (r + k), load(own + 4 * (r + k)) + point[k]);
            }
        triangle(L + c, s.height, part, s.diagonal + c, own + 4 * c);
        subtract_product<lanes>(L + c + part, s.height, part, s.width - c - part, own + 4 * c,
                                beside + static_cast<std::ptrdiff_t>(c + part) * lanes, ahead);
        subtract_product<lanes>(L + s.width, s.height, part, rest, own + 4 * c, below, ahead);
    }
    for (int r = 0; r < rest; r += 4) {
        to_points<lanes>(below, r, point);
        for (int k = 0; k < least(4, rest - r); ++k) {
            const std::ptrdiff_t row = s.rows[r + k];
            T* const to =
                row < inside ? points + 4 * row : sums + 4 * static_cast<std::ptrdiff_t>(place[row]);
            store(to, load(to) + point[k]);
        }
    }
}

template <int lanes, class T>
inline void backward(const LaneSupernode<T>& s, T* own, const T* points, T* workspace)
{
    constexpr int width = LaneSupernode<T>::triangle_width;
    const int rest = s.height - s.width;
    const std::ptrdiff_t ahead = fetched_ahead<T>(s.height);
    T* const below = workspace;
    T* const beside = below + static_cast<std::ptrdiff_t>(in_eights(rest)) * lanes;
    Lanes<T> point[4];
    for (int r = 0; r < in_eights(rest); r += 4) {
        for (int k = 0; k < 4; ++k)
            point[k] =
                r + k < rest ? load(points + 4 * static_cast<std::ptrdiff_t>(s.rows[r + k])) : Lanes<T>{};
        from_points<lanes>(point, below, r);
    }
    for (int c = (s.width - 1) / width * width; c >= 0; c -= width) {
        const int part = least(width, s.width - c);
        const T* const L = s.values + static_cast<std::ptrdiff_t>(c) * s.height;
        subtract_transposed<lanes>(L + c + part, s.height, part, s.width - c - part,
                                   beside + static_cast<std::ptrdiff_t>(c + part) * lanes, own + 4 * c,
                                   ahead);
        subtract_transposed<lanes>(L + s.width, s.height, part, rest, below, own + 4 * c, ahead);
        triangle_transposed(L + c, s.height, part, s.diagonal + c, own + 4 * c);
        if (c > 0)
            for (int r = c; r < in_eights(c + part); r += 4) {
                for (int k = 0; k < 4; ++k)
                    point[k] = r + k < c + part ? load(own + 4 * (r + k)) : Lanes<T>{};
                from_points<lanes>(point, beside, r);
            }
    }
}

template <class T>
void forward_lanes(const LaneSupernode<T>& s, int lanes, T* own, T* points, int inside, T* sums,
                   const int* place, T* workspace)
{
    if (lanes == 3)
        forward<3>(s, own, points, inside, sums, place, workspace);
    else
        forward<4>(s, own, points, inside, sums, place, workspace);
}

template <class T>
void backward_lanes(const LaneSupernode<T>& s, int lanes, T* own, const T* points, T* workspace)
{
    if (lanes == 3)
        backward<3>(s, own, points, workspace);
    else
        backward<4>(s, own, points, workspace);
}

} // namespace

template <>
const sinew::LaneKernels<double> sinew::LaneKernels<double>::SINEW_INSTRUCTIONS{forward_lanes,
                                                                                backward_lanes};
template <>
const sinew::LaneKernels<float> sinew::LaneKernels<float>::SINEW_INSTRUCTIONS{forward_lanes, backward_lanes};
