// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of FieldKernels, compiled once for each set of instructions. A point per lane of two vectors.

#include "native/core/simd/lane_math.inl"

namespace sinew {

namespace {

/// Two vectors of lanes: while the root or the quotient of one is on its way, the other is computed. A step
/// needs the result of the step before, so one alone would wait most of the time.
struct Wide
{
    Lanes<double> low, high;
};
constexpr int width = 2 * lane_count;

inline Wide constant(double value) { return {::constant(value), ::constant(value)}; }
inline Wide load(const double* from) { return {::load(from), ::load(from + lane_count)}; }
inline void store(double* to, Wide a) { ::store(to, a.low), ::store(to + lane_count, a.high); }
inline Wide operator+(Wide a, Wide b) { return {a.low + b.low, a.high + b.high}; }
inline Wide operator-(Wide a, Wide b) { return {a.low - b.low, a.high - b.high}; }
inline Wide operator+(Wide a, double b) { return a + constant(b); }
inline Wide operator*(Wide a, Wide b) { return {a.low * b.low, a.high * b.high}; }
inline Wide operator*(double a, Wide b) { return {a * b.low, a * b.high}; }
inline Wide operator/(Wide a, Wide b) { return {a.low / b.low, a.high / b.high}; }
inline Wide root(Wide a) { return {::root(a.low), ::root(a.high)}; }
inline Wide larger(Wide a, Wide b) { return {::larger(a.low, b.low), ::larger(a.high, b.high)}; }

struct WideMask
{
    decltype(::above(Lanes<double>{}, Lanes<double>{})) low, high;
};

inline WideMask above(Wide a, Wide b) { return {::above(a.low, b.low), ::above(a.high, b.high)}; }
inline Wide choose(WideMask mask, Wide yes, Wide no)
{
    return {::choose(mask.low, yes.low, no.low), ::choose(mask.high, yes.high, no.high)};
}
inline bool any(WideMask mask) { return (mask_bits(mask.low) | mask_bits(mask.high)) != 0; }

struct Place
{
    Wide x, y, z;
};

inline Place operator+(const Place& a, const Place& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Place operator*(double s, const Place& a) { return {s * a.x, s * a.y, s * a.z}; }

inline Place operator*(Wide s, const Place& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Place operator-(const Place& a, const Place& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

inline Wide dot(const double* a, const Place& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
inline Wide dot(const Place& a, const Place& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// a x b
inline Place cross(const double* a, const Place& b)
{
    return {a[1] * b.z - a[2] * b.y, a[2] * b.x - a[0] * b.z, a[0] * b.y - a[1] * b.x};
}

/// The field at one time, which may differ from lane to lane.
struct Moment
{
    Place centre, axis, own_axis;
    Wide inner, per_width;
};

/// An angle that is another one in each lane, or the same in all.
struct WideTurn
{
    Wide cosine, sine;
};
struct EvenTurn
{
    double cosine, sine;
};

/// The moment at the times t. `Turn` is one of the two.
template <class Turn>
inline Moment moment(const FieldPiece& piece, Wide t, const Turn& halfway, const Turn& own)
{
    const auto along = [&](const double* from, const double* way) -> Place {
        return {constant(from[0]) + way[0] * t, constant(from[1]) + way[1] * t,
                constant(from[2]) + way[2] * t};
    };
    const auto turned = [](const double* axis, const double* side, const Turn& turn) -> Place {
        return {constant(0.0) + (axis[0] * turn.cosine + side[0] * turn.sine),
                constant(0.0) + (axis[1] * turn.cosine + side[1] * turn.sine),
                constant(0.0) + (axis[2] * turn.cosine + side[2] * turn.sine)};
    };
    Moment now;
    now.centre = along(piece.centre, piece.move);
    now.axis = turned(piece.axis, piece.side, halfway);
    now.own_axis = turned(piece.own_axis, piece.own_side, own);
    now.inner = constant(piece.inner[0]) + piece.inner[1] * t;
    now.per_width = constant(1.0) / ((constant(piece.outer[0]) + piece.outer[1] * t) - now.inner);
    return now;
}

/// Cosines and sines of angles between 0 and pi, by their series: libraries differ in the last bits.
inline WideTurn turn_by(Wide angle)
{
    const Wide square = angle * angle;
    Wide cosine = constant(1.0), sine = cosine;
    for (int k = 15; k > 0; --k) {
        cosine = constant(1.0) - (1.0 / (2.0 * k * (2.0 * k - 1.0))) * (square * cosine);
        sine = constant(1.0) - (1.0 / (2.0 * k * (2.0 * k + 1.0))) * (square * sine);
    }
    return {cosine, angle * sine};
}

inline Moment moment_at(const FieldPiece& piece, Wide t)
{
    const WideTurn none{constant(1.0), constant(0.0)};
    if (!piece.bends)
        return moment(piece, t, none, none);
    return moment(piece, t, turn_by(piece.angle * t), turn_by(piece.own_angle * t));
}

/// An angle that grows in even steps: turned on by a product, as sines cost more than the field.
class Turning
{
public:
    Turning(double angle, double step)
    {
        const WideTurn turn = turn_by(constant(angle * step));
        step_ = {turn.cosine.low[0], turn.sine.low[0]};
    }
    const EvenTurn& now() const { return now_; }
    void advance()
    {
        now_ = {now_.cosine * step_.cosine - now_.sine * step_.sine,
                now_.sine * step_.cosine + now_.cosine * step_.sine};
    }

private:
    EvenTurn now_{1.0, 0.0}, step_;
};

/// Walks through the times of a piece in even steps, the same for all lanes.
class Clock
{
public:
    Clock(const FieldPiece& piece, double step)
        : piece_(piece), halfway_(piece.angle, step), own_(piece.own_angle, step)
    {
    }

    Moment now() const { return moment(piece_, constant(t_), halfway_.now(), own_.now()); }

    void advance(double t)
    {
        t_ = t;
        halfway_.advance();
        own_.advance();
    }

private:
    const FieldPiece& piece_;
    double t_ = 0.0;
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
    const Place y = at - now.centre;
    const Place turned = cross(piece.turn, y);
    const Wide square = dot(y, y);
    Wide b, slope;
    if (piece.bends) {
        // curl(beta phi A) = beta phi w x y + grad(beta phi) x A, A = h (w . y) a - n^2 / 2 w
        const double* w = piece.turn;
        const double w2 = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        const Place& a = now.own_axis;
        const Wide along = dot(w, y), up = dot(a, y);
        const Place out = y - up * a;
        const Wide apart = dot(out, out), distance = root(apart);
        const Wide half = constant(0.5) * (apart - (w2 > 0.0 ? 1.0 / w2 : 0.0) * (along * along));
        const Wide lift = up * along;
        const Place A{a.x * lift - w[0] * half, a.y * lift - w[1] * half, a.z * lift - w[2] * half};
        Wide fade, fading;
        blend(now.per_width * (dot(now.axis, y) - now.inner), b, slope);
        blend((1.0 / piece.width) * distance - constant(1.0), fade, fading);
        const Wide phi = constant(1.0) - fade;
        const Wide rising = now.per_width * (slope * phi);
        const Wide falling = (-1.0 / piece.width) * (b * fading) / larger(distance, constant(1e-300));
        const Place steep = rising * now.axis + falling * out;
        const Place around{steep.y * A.z - steep.z * A.y, steep.z * A.x - steep.x * A.z,
                           steep.x * A.y - steep.y * A.x};
        return (b * phi) * turned + around;
    }
    // (beta^2 + beta beta' r) v - beta beta' / r (y . v) y + beta w x y
    const Wide r = root(square);
    blend(now.per_width * (r - now.inner), b, slope);
    const Wide beta = constant(1.0) - b;
    const Wide steep = constant(0.0) - now.per_width * (beta * slope); // beta beta'
    const Wide straight = beta * beta + steep * r;
    const Wide back = steep * (dot(piece.move, y) / larger(r, constant(1e-300)));
    const double* v = piece.move;
    return {v[0] * straight - back * y.x + beta * turned.x, v[1] * straight - back * y.y + beta * turned.y,
            v[2] * straight - back * y.z + beta * turned.z};
}

/// Where a step of the classical rule of order 4 leads: it sees the field at three times.
template <class Step>
inline Place step_of_four(const FieldPiece& piece, const Moment& middle, const Moment& end, const Place& x,
                          const Place& first, Step h)
{
    const Place second = field(piece, middle, x + (0.5 * h) * first);
    const Place third = field(piece, middle, x + (0.5 * h) * second);
    const Place fourth = field(piece, end, x + h * third);
    return x + ((1.0 / 6.0) * h) * ((first + fourth) + 2.0 * (second + third));
}

inline Place read(const double* points)
{
    return {load(points), load(points + width), load(points + 2 * width)};
}

inline void write(double* points, const Place& place)
{
    store(points, place.x), store(points + width, place.y), store(points + 2 * width, place.z);
}

void flow(const FieldPiece& piece, int steps, int order, double* points)
{
    Place x = read(points);
    const double h = 1.0 / steps;
    Clock clock(piece, order == 1 ? h : 0.5 * h);
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
        clock.advance((k + 1) * h);
        const Moment end = clock.now();
        x = order == 2 ? x + h * field(piece, middle, x + (0.5 * h) * first)
                       : step_of_four(piece, middle, end, x, first, h);
        begin = end;
    }
    write(points, x);
}

void flow_to(const FieldPiece& piece, int least_steps, double tolerance, double* points)
{
    constexpr double shortest = 0x1p-16; // a step that is taken whatever its error
    const Wide one = constant(1.0), zero = constant(0.0), longest = constant(1.0 / least_steps);
    Place x = read(points);
    Wide t = zero, h = longest;
    for (;;) {
        const Wide left = one - t;
        const auto going = above(left, constant(1e-12));
        if (!any(going))
            break;
        h = choose(above(h, left), left, h);
        h = choose(going, h, zero);
        const Moment begin = moment_at(piece, t), middle = moment_at(piece, t + 0.5 * h);
        const Moment end = moment_at(piece, t + h);
        const Moment before = moment_at(piece, t + 0.25 * h), after = moment_at(piece, t + 0.75 * h);
        const Place first = field(piece, begin, x);
        const Place whole = step_of_four(piece, middle, end, x, first, h);
        const Wide half = 0.5 * h;
        const Place halfway = step_of_four(piece, before, middle, x, first, half);
        const Place fine = step_of_four(piece, after, end, halfway, field(piece, middle, halfway), half);
        const Place off = (1.0 / 15.0) * (fine - whole);
        const Wide error = root(dot(off, off)), allowed = tolerance * h;
        // What is left of the error is of higher order.
        const auto too_far = above(error, choose(above(h, constant(shortest)), allowed, constant(1e300)));
        x.x = choose(too_far, x.x, fine.x + off.x);
        x.y = choose(too_far, x.y, fine.y + off.y);
        x.z = choose(too_far, x.z, fine.z + off.z);
        t = choose(too_far, t, t + h);
        Wide factor = 0.9 * root(root(allowed / larger(error, constant(1e-300))));
        factor = choose(above(factor, constant(4.0)), constant(4.0), larger(factor, constant(0.2)));
        h = h * factor;
        h = choose(above(h, longest), longest, larger(h, constant(0.5 * shortest)));
    }
    write(points, x);
}

void velocity(const FieldPiece& piece, double t, const double* points, double* velocities)
{
    write(velocities, field(piece, moment_at(piece, constant(t)), read(points)));
}

} // namespace

const FieldKernels FieldKernels::SINEW_INSTRUCTIONS{width, sinew::flow, sinew::flow_to, sinew::velocity};

} // namespace sinew
