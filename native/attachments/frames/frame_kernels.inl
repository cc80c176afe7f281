// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of FrameKernels, compiled once for each set of instructions. One lane is one patch.

#include "native/core/simd/lane_math.inl"
#include "native/operators/fits/rotation_fit.inl"

namespace {

using sinew::FourMotions;
using sinew::FourRests;
using sinew::FrameArms;
using sinew::FrameMap;
using sinew::FrameSlot;
using sinew::LooseSlot;
using L = Lanes<double>;

constexpr double no_area = 1e-290; // squared

struct Three
{
    L x, y, z;
};

inline Three operator+(const Three& a, const Three& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Three operator-(const Three& a, const Three& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Three operator*(const Three& a, L factor) { return {a.x * factor, a.y * factor, a.z * factor}; }
inline L dot(const Three& a, const Three& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Three cross(const Three& a, const Three& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Three rows_of(const double (&from)[3][4]) { return {load(from[0]), load(from[1]), load(from[2])}; }
inline void set_rows(double (&to)[3][4], const Three& a)
{
    store(to[0], a.x);
    store(to[1], a.y);
    store(to[2], a.z);
}

/// Points of four patches.
inline Three gather(const double* points, const int* vertices)
{
    const auto row = [&](int k) { return points + 3 * static_cast<std::ptrdiff_t>(vertices[k]); };
    Three three;
    load_columns(row(0), row(1), row(2), row(3), three.x, three.y, three.z);
    return three;
}

/// 1 / sqrt(2 A) from (2 A)^2, and 0 without an area.
inline L inverse_root(L square)
{
    const auto wide = above(square, constant(no_area));
    return choose(wide, constant(1.0) / root(root(choose(wide, square, constant(1.0)))), constant(0.0));
}

/// A triangle of each patch: its centre, less `from`, and its normal of length 2 A.
struct Measure
{
    Three centre, normal;
    L square; ///< of the normal's length

    Measure(const FrameSlot& slot, const double* points, const Three& from)
    {
        const Three a = gather(points, slot.corners[0]);
        const Three b = gather(points, slot.corners[1]) - a, c = gather(points, slot.corners[2]) - a;
        centre = (a - from) + (b + c) * constant(1.0 / 3);
        normal = cross(b, c);
        square = dot(normal, normal);
    }
};

/// Adds a b^T to a matrix, row by row.
inline void add_product(L* C, const Three& a, const Three& b)
{
    const L rows[3] = {a.x, a.y, a.z};
    for (int r = 0; r < 3; ++r) {
        C[3 * r] = C[3 * r] + rows[r] * b.x;
        C[3 * r + 1] = C[3 * r + 1] + rows[r] * b.y;
        C[3 * r + 2] = C[3 * r + 2] + rows[r] * b.z;
    }
}

/// C and the anchors of four patches, the latter less a point.
struct Sums
{
    L C[9];
    Three anchor{constant(0.0), constant(0.0), constant(0.0)};

    Sums()
    {
        for (L& entry : C)
            entry = constant(0.0);
    }
    /// \param normal  of the length sqrt(2 A).
    void add(const FrameSlot& slot, const Three& centre, const Three& normal, const Three& arm,
             const Three& rest_normal)
    {
        anchor = anchor + centre * load(slot.anchors);
        add_product(C, centre, arm);
        add_product(C, normal, rest_normal);
    }
};

inline L determinant(const L* m, Three& first_cofactors)
{
    first_cofactors = {m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6]};
    return m[0] * first_cofactors.x + m[1] * first_cofactors.y + m[2] * first_cofactors.z;
}

int measure(const FrameSlot* slots, int count, const double* points, FrameArms* arms, FourRests& rests,
            double* C)
{
    const Three from = gather(points, slots[0].corners[0]);
    const L zero = constant(0.0), one = constant(1.0);
    Three mean{zero, zero, zero}, centres[sinew::most_slots], normals[sinew::most_slots];
    for (int i = 0; i < count; ++i) {
        const Measure t(slots[i], points, from);
        const L w = load(slots[i].weights), narrow = inverse_root(t.square);
        mean = mean + t.centre * w;
        centres[i] = t.centre;
        normals[i] = t.normal * narrow;
        set_rows(arms[i].normals, t.normal * (constant(0.5) * w * (narrow * narrow) * narrow));
    }
    L spread = zero;
    for (int i = 0; i < count; ++i) {
        const Three arm = centres[i] - mean;
        set_rows(arms[i].arms, arm);
        spread = spread + load(slots[i].weights) * dot(arm, arm);
    }
    const L share = choose(above(spread, constant(no_area)), one / larger(spread, constant(no_area)), zero);
    Sums sums;
    for (int i = 0; i < count; ++i) {
        const Three arm = rows_of(arms[i].arms) * (load(slots[i].weights) * share);
        set_rows(arms[i].arms, arm);
        sums.add(slots[i], centres[i], normals[i], arm, rows_of(arms[i].normals));
    }
    set_rows(rests.anchors, from + sums.anchor);
    const L* const c = sums.C;
    Three first;
    const L det = determinant(c, first), trace = c[0] + c[4] + c[8];
    const auto safe = above(det, constant(1e-4) * trace * trace * trace) & above(trace, constant(0.1));
    const L inverse = one / choose(safe, det, one);
    const L cofactors[9] = {first.x, c[2] * c[7] - c[1] * c[8], c[1] * c[5] - c[2] * c[4],
                            first.y, c[0] * c[8] - c[2] * c[6], c[2] * c[3] - c[0] * c[5],
                            first.z, c[1] * c[6] - c[0] * c[7], c[0] * c[4] - c[1] * c[3]};
    for (int k = 0; k < 9; ++k) {
        store(rests.inverse[k], cofactors[k] * inverse);
        store(C + 4 * k, c[k]);
    }
    return mask_bits(safe);
}

/// cos and sin of an angle in [0, pi / 3], by their series.
inline void turn(L angle, L& cosine, L& sine)
{
    const L u = angle * angle;
    cosine = constant(1.0);
    sine = constant(1.0);
    for (int k = 9; k > 0; --k) {
        cosine = constant(1.0) - cosine * u * constant(1.0 / ((2 * k - 1) * (2 * k)));
        sine = constant(1.0) - sine * u * constant(1.0 / ((2 * k) * (2 * k + 1)));
    }
    sine = sine * angle;
}

/// s of MovingFrames, from G = C C_rest^+. The squared singular values are the roots of a cubic polynomial.
inline L scale_of(const L* G)
{
    const auto product = [&](int i, int j) {
        return G[i] * G[j] + G[3 + i] * G[3 + j] + G[6 + i] * G[6 + j];
    };
    const L zero = constant(0.0), one = constant(1.0);
    const L s00 = product(0, 0), s11 = product(1, 1), s22 = product(2, 2);
    const L s01 = product(0, 1), s02 = product(0, 2), s12 = product(1, 2);
    const L mean = (s00 + s11 + s22) * constant(1.0 / 3);
    const L d0 = s00 - mean, d1 = s11 - mean, d2 = s22 - mean;
    const L width = root((d0 * d0 + d1 * d1 + d2 * d2 + constant(2.0) * (s01 * s01 + s02 * s02 + s12 * s12)) *
                         constant(1.0 / 6));
    const L inverse = one / larger(width, constant(1e-290));
    const L b[9] = {d0 * inverse,  s01 * inverse, s02 * inverse, s01 * inverse, d1 * inverse,
                    s12 * inverse, s02 * inverse, s12 * inverse, d2 * inverse};
    Three ignored;
    const L half = determinant(b, ignored) * constant(0.5);
    L cosine, sine;
    turn(angle_between(root(larger(one - half * half, zero)), half) * constant(1.0 / 3), cosine, sine);
    const L least = constant(1e-18); // of a squared scale: a patch that collapsed
    const L high = root(larger(mean + constant(2.0) * width * cosine, least));
    const L low = root(larger(mean - width * (cosine + constant(1.7320508075688772) * sine), least));
    const L grown = larger(low * root(low / high), one), shrunk = high * root(high / low);
    return grown * choose(above(one, shrunk), shrunk, one);
}

int fit(const FrameSlot* slots, const FrameArms* arms, int count, const FourRests& rests,
        const double* points, FourMotions& motions, double* C)
{
    const Three from = gather(points, slots[0].corners[0]);
    Sums sums;
    for (int i = 0; i < count; ++i) {
        const Measure t(slots[i], points, from);
        sums.add(slots[i], t.centre, t.normal * inverse_root(t.square), rows_of(arms[i].arms),
                 rows_of(arms[i].normals));
    }
    set_rows(motions.anchors, from + sums.anchor);
    const L* const c = sums.C;
    L other[9];
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
            other[3 * r + k] = c[3 * r] * load(rests.inverse[k]) + c[3 * r + 1] * load(rests.inverse[3 + k]) +
                               c[3 * r + 2] * load(rests.inverse[6 + k]);
    store(motions.scales, scale_of(other));
    FourFits fits;
    fits.begin(c, constant(0.0));
    for (int step = 0; step < most_newton_steps; ++step) {
        fits.step();
        if (fits.done())
            break;
    }
    const auto safe = fits.finish(other);
    for (int k = 0; k < 9; ++k) {
        store(motions.rotations[k], other[k]);
        store(C + 4 * k, c[k]);
    }
    return mask_bits(safe);
}

inline void store_point(double* to, L p)
{
    for (int k = 0; k < 3; ++k)
        to[k] = p[k];
}

inline L carried(const L (&columns)[4], const double* point)
{
    return columns[0] * constant(point[0]) + columns[1] * constant(point[1]) +
           columns[2] * constant(point[2]) + columns[3];
}

void carry(const FrameMap& map, const int* vertices, int count, const double* from, double* to)
{
    const L columns[4] = {load(map.columns[0]), load(map.columns[1]), load(map.columns[2]),
                          load(map.columns[3])};
    for (int i = 0; i < count; ++i) {
        const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(vertices[i]);
        store_point(to + at, carried(columns, from + at));
    }
}

void carry_row(const FrameMap& map, int count, const double* from, double* to)
{
    const L columns[4] = {load(map.columns[0]), load(map.columns[1]), load(map.columns[2]),
                          load(map.columns[3])};
    for (; count > 1; --count, from += 3, to += 3)
        store(to, carried(columns, from)); // the fourth number gives way to the next point
    if (count > 0)
        store_point(to, carried(columns, from));
}

void bend(const FrameMap* maps, const int* offsets, const int* frames, const double* shares,
          const int* vertices, int count, const double* from, double* to)
{
    for (int i = 0; i < count; ++i) {
        L columns[4] = {constant(0.0), constant(0.0), constant(0.0), constant(0.0)};
        for (int s = offsets[i]; s < offsets[i + 1]; ++s)
            for (int k = 0; k < 4; ++k)
                columns[k] = columns[k] + shares[s] * load(maps[frames[s]].columns[k]);
        const std::ptrdiff_t at = 3 * static_cast<std::ptrdiff_t>(vertices[i]);
        store_point(to + at, carried(columns, from + at));
    }
}

/// The triangles beneath four loose vertices: a corner, the sides from there, and the normal of length 2 A.
struct Beneath
{
    Three corner, b, c, normal;
    L square;

    Beneath(const LooseSlot& slot, const double* points)
        : corner(gather(points, slot.corners[0])), b(gather(points, slot.corners[1]) - corner),
          c(gather(points, slot.corners[2]) - corner), normal(cross(b, c)), square(dot(normal, normal))
    {
    }
};

/// Where loose vertices are between the corners, and how far above.
inline Three places_on(const LooseSlot& slot, const double* points)
{
    const Beneath t(slot, points);
    const Three arm = gather(points, slot.vertices) - t.corner;
    const L share = choose(above(t.square, constant(no_area)),
                           constant(1.0) / larger(t.square, constant(no_area)), constant(0.0));
    return {dot(cross(arm, t.c), t.normal) * share, dot(cross(t.b, arm), t.normal) * share,
            dot(arm, t.normal) * share * root(root(t.square))};
}

void place(LooseSlot* slots, int count, const double* points)
{
    for (int i = 0; i < count; ++i)
        set_rows(slots[i].places, places_on(slots[i], points));
}

void ride(const LooseSlot* slots, int count, const double* from, double* to)
{
    for (int i = 0; i < count; ++i) {
        const LooseSlot& slot = slots[i];
        const Three at = from ? places_on(slot, from) : rows_of(slot.places);
        const Beneath t(slot, to);
        const Three p = t.corner + (t.b * at.x + t.c * at.y + t.normal * (at.z * inverse_root(t.square)));
        for (int k = 0; k < 4; ++k) {
            double* const row = to + 3 * static_cast<std::ptrdiff_t>(slot.vertices[k]);
            row[0] = p.x[k];
            row[1] = p.y[k];
            row[2] = p.z[k];
        }
    }
}

} // namespace

const sinew::FrameKernels sinew::FrameKernels::SINEW_INSTRUCTIONS{::measure, ::fit,   ::carry, ::carry_row,
                                                                  ::bend,    ::place, ::ride};
