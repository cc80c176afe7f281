// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of FieldKernels for lane_count points at a time, compiled once for each set of instructions.

#include "native/core/simd/lane_math.inl"

#ifdef __GNUC__
#define SINEW_SIN __builtin_sin
#define SINEW_COS __builtin_cos
#else
#define SINEW_SIN std::sin
#define SINEW_COS std::cos
#endif

namespace sinew {

namespace {

using Wide = Lanes<double>;

struct Place
{
    Wide x, y, z;
};

inline Place operator+(const Place& a, const Place& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Place operator*(double s, const Place& a) { return {s * a.x, s * a.y, s * a.z}; }

inline Wide dot(const double* a, const Place& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
/// a x b
inline Place cross(const double* a, const Place& b)
{
    return {a[1] * b.z - a[2] * b.y, a[2] * b.x - a[0] * b.z, a[0] * b.y - a[1] * b.x};
}

/// The field at one time.
struct Moment
{
    double centre[3], axis[3], own_axis[3];
    double inner, per_width;
};

/// An angle that grows in even steps: turned on by a product, as sines cost more than the field.
class Turning
{
public:
    Turning() = default;
    Turning(double angle, double t, double step)
        : cosine_(SINEW_COS(angle * t)), sine_(SINEW_SIN(angle * t)), step_cosine_(SINEW_COS(angle * step)),
          step_sine_(SINEW_SIN(angle * step))
    {
    }
    double between(double axis, double side) const { return cosine_ * axis + sine_ * side; }
    void advance()
    {
        const double cosine = cosine_ * step_cosine_ - sine_ * step_sine_;
        sine_ = sine_ * step_cosine_ + cosine_ * step_sine_;
        cosine_ = cosine;
    }

private:
    double cosine_ = 1.0, sine_ = 0.0, step_cosine_ = 1.0, step_sine_ = 0.0;
};

/// Walks through the times of a piece in even steps.
class Clock
{
public:
    Clock(const FieldPiece& piece, double t, double step) : piece_(piece), t_(t)
    {
        if (piece.bends) {
            halfway_ = Turning(piece.angle, t, step);
            own_ = Turning(piece.own_angle, t, step);
        }
    }

    Moment now() const
    {
        Moment moment;
        for (int k = 0; k < 3; ++k) {
            moment.centre[k] = piece_.centre[k] + t_ * piece_.move[k];
            moment.axis[k] = halfway_.between(piece_.axis[k], piece_.side[k]);
            moment.own_axis[k] = own_.between(piece_.own_axis[k], piece_.own_side[k]);
        }
        moment.inner = piece_.inner[0] + t_ * piece_.inner[1];
        moment.per_width = 1.0 / (piece_.outer[0] + t_ * piece_.outer[1] - moment.inner);
        return moment;
    }

    void advance(double t)
    {
        t_ = t;
        halfway_.advance();
        own_.advance();
    }

private:
    const FieldPiece& piece_;
    double t_;
    Turning halfway_, own_;
};

/// b(u) = 4 u^3 (1 - u) + u^4 and its derivative for u clamped to [0, 1].
inline void blend(Wide u, Wide& b, Wide& slope)
{
    const Wide zero = constant(0.0), one = constant(1.0);
    u = choose(above(u, zero), u, zero);
    u = choose(above(one, u), u, one);
    const Wide square = u * u;
    b = square * (u * (constant(4.0) - constant(3.0) * u));
    slope = constant(12.0) * (square * (one - u));
}

inline Place field(const FieldPiece& piece, const Moment& now, const Place& at)
{
    const Place y{at.x - constant(now.centre[0]), at.y - constant(now.centre[1]),
                  at.z - constant(now.centre[2])};
    const Place turned = cross(piece.turn, y);
    const Wide square = y.x * y.x + y.y * y.y + y.z * y.z;
    Wide b, slope;
    if (piece.bends) {
        // curl(beta phi A) = beta phi w x y + grad(beta phi) x A, A = h (w . y) a - n^2 / 2 w
        const double *w = piece.turn, *a = now.own_axis;
        const double w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        const Wide along = dot(w, y), up = dot(a, y);
        const Place out{y.x - a[0] * up, y.y - a[1] * up, y.z - a[2] * up};
        const Wide apart = out.x * out.x + out.y * out.y + out.z * out.z, distance = root(apart);
        const Wide half = constant(0.5) * (apart - (w2 > 0.0 ? 1.0 / w2 : 0.0) * (along * along));
        const Wide lift = up * along;
        const Place A{a[0] * lift - w[0] * half, a[1] * lift - w[1] * half, a[2] * lift - w[2] * half};
        Wide fade, fading;
        blend(constant(now.per_width) * (dot(now.axis, y) - constant(now.inner)), b, slope);
        blend((1.0 / piece.width) * distance - constant(1.0), fade, fading);
        const Wide phi = constant(1.0) - fade, full = b * phi;
        const Wide rising = now.per_width * (slope * phi);
        const Wide falling = (-1.0 / piece.width) * (b * fading) / larger(distance, constant(1e-300));
        const Place steep{now.axis[0] * rising + falling * out.x, now.axis[1] * rising + falling * out.y,
                          now.axis[2] * rising + falling * out.z};
        return {full * turned.x + (steep.y * A.z - steep.z * A.y),
                full * turned.y + (steep.z * A.x - steep.x * A.z),
                full * turned.z + (steep.x * A.y - steep.y * A.x)};
    }
    // (beta^2 + beta beta' r) v - beta beta' / r (y . v) y + beta w x y
    const Wide r = root(square);
    blend(constant(now.per_width) * (r - constant(now.inner)), b, slope);
    const Wide beta = constant(1.0) - b;
    const Wide steep = constant(-now.per_width) * (beta * slope); // beta beta'
    const Wide straight = beta * beta + steep * r;
    const Wide back = steep * (dot(piece.move, y) / larger(r, constant(1e-300)));
    const double* v = piece.move;
    return {v[0] * straight - back * y.x + beta * turned.x, v[1] * straight - back * y.y + beta * turned.y,
            v[2] * straight - back * y.z + beta * turned.z};
}

inline Place read(const double* points)
{
    return {load(points), load(points + lane_count), load(points + 2 * lane_count)};
}

inline void write(double* points, const Place& place)
{
    store(points, place.x), store(points + lane_count, place.y), store(points + 2 * lane_count, place.z);
}

void flow(const FieldPiece& piece, int steps, int order, double* points)
{
    Place x = read(points);
    const double h = 1.0 / steps;
    Clock clock(piece, 0.0, order == 1 ? h : 0.5 * h);
    Moment begin = clock.now();
    for (int k = 0; k < steps; ++k) {
        const Place first = field(piece, begin, x);
        if (order == 1) {
            x = x + h * first;
            clock.advance((k + 1) * h);
            begin = clock.now();
            continue;
        }
        clock.advance((k + 0.5) * h);
        const Moment middle = clock.now();
        const Place second = field(piece, middle, x + (0.5 * h) * first);
        clock.advance((k + 1) * h);
        const Moment end = clock.now();
        if (order == 2) {
            x = x + h * second;
        } else {
            const Place third = field(piece, middle, x + (0.5 * h) * second);
            const Place fourth = field(piece, end, x + h * third);
            x = x + (h / 6.0) * ((first + fourth) + 2.0 * (second + third));
        }
        begin = end;
    }
    write(points, x);
}

void velocity(const FieldPiece& piece, double t, const double* points, double* velocities)
{
    write(velocities, field(piece, Clock(piece, t, 0.0).now(), read(points)));
}

} // namespace

const FieldKernels FieldKernels::SINEW_INSTRUCTIONS{lane_count, sinew::flow, sinew::velocity};

} // namespace sinew
