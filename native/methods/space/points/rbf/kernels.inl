// SPDX-License-Identifier: GPL-3.0-or-later
// The body of RbfKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

using L = Lanes<double>;
constexpr int parts = 8 / lane_count;

inline L positive(L a) { return choose(above(a, constant(0.0)), a, constant(0.0)); }

struct Triharmonic
{
    static L of(L square, L) { return square * root(square); }
};
struct Biharmonic
{
    static L of(L square, L) { return constant(0.0) - root(square); }
};
struct WendlandC0
{
    static L of(L square, L scale)
    {
        const L t = positive(constant(1.0) - scale * root(square));
        return t * t;
    }
};
struct WendlandC2
{
    static L of(L square, L scale)
    {
        const L r = scale * root(square), t = positive(constant(1.0) - r), t2 = t * t;
        return t2 * t2 * (constant(4.0) * r + constant(1.0));
    }
};
struct WendlandC4
{
    static L of(L square, L scale)
    {
        const L r = scale * root(square), t = positive(constant(1.0) - r), t2 = t * t;
        const L p = (constant(35.0 / 3.0) * r + constant(6.0)) * r + constant(1.0);
        return t2 * t2 * t2 * p;
    }
};

/// Eight points.
struct Eight
{
    L x[parts], y[parts], z[parts];

    explicit Eight(const double* points)
    {
        for (int p = 0; p < parts; ++p) {
            x[p] = load(points + lane_count * p);
            y[p] = load(points + 8 + lane_count * p);
            z[p] = load(points + 16 + lane_count * p);
        }
    }
    L square(int p, const double* centre) const
    {
        const L dx = x[p] - constant(centre[0]), dy = y[p] - constant(centre[1]),
                dz = z[p] - constant(centre[2]);
        return dx * dx + dy * dy + dz * dz;
    }
};

template <class Function>
void values(const double* centres, int count, double scale, const double* points, double* values)
{
    const Eight at(points);
    const L factor = constant(scale);
    for (int j = 0; j < count; ++j, centres += 3, values += 8)
        for (int p = 0; p < parts; ++p)
            store(values + lane_count * p, Function::of(at.square(p, centres), factor));
}

template <class Function>
void sums(const double* table, int count, double scale, const double* points, double* sums)
{
    const Eight at(points);
    const L factor = constant(scale);
    L sum[3][parts];
    for (int k = 0; k < 3; ++k)
        for (int p = 0; p < parts; ++p)
            sum[k][p] = load(sums + 8 * k + lane_count * p);
    for (int j = 0; j < count; ++j, table += 6)
        for (int p = 0; p < parts; ++p) {
            const L value = Function::of(at.square(p, table), factor);
            for (int k = 0; k < 3; ++k)
                sum[k][p] = sum[k][p] + constant(table[3 + k]) * value;
        }
    for (int k = 0; k < 3; ++k)
        for (int p = 0; p < parts; ++p)
            store(sums + 8 * k + lane_count * p, sum[k][p]);
}

} // namespace

const sinew::RbfKernels sinew::RbfKernels::SINEW_INSTRUCTIONS{
    {::values<Triharmonic>, ::values<Biharmonic>, ::values<WendlandC0>, ::values<WendlandC2>,
     ::values<WendlandC4>},
    {::sums<Triharmonic>, ::sums<Biharmonic>, ::sums<WendlandC0>, ::sums<WendlandC2>, ::sums<WendlandC4>}};
