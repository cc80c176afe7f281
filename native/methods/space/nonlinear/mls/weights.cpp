// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/mls/weights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

/// What lies so close to a segment, as a share of the size, lies on it.
constexpr double on_segment = 1e-14;

/// Places and weights of Gauss and Legendre's quadrature on [-1, 1].
constexpr int nodes = 8;
constexpr double half_places[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                  0.9602898564975363};
constexpr double half_weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                   0.1012285362903763};

/// (least / square)^alpha
double decay(double least, double square, double alpha)
{
    const double ratio = least / square;
    return alpha == 1.0 ? ratio : alpha == 2.0 ? ratio * ratio : std::pow(ratio, alpha);
}

struct Segment
{
    Vector3 from, along; ///< relative to v
    double length, foot, distance; ///< the foot of v is at `foot` of the length

    Segment(const Vector3& a, const Vector3& b, const Vector3& v) : from(a - v), along(b - a)
    {
        length = along.norm();
        foot = length > 0.0 ? -from.dot(along) / (length * length) : 0.0;
        distance = (from + foot * along).norm();
    }
    double least_square() const { return (from + std::clamp(foot, 0.0, 1.0) * along).squaredNorm(); }
};

void add(double* ten, double w, const Vector3& p)
{
    *ten++ += w;
    for (int a = 0; a < 3; ++a)
        *ten++ += w * p[a];
    for (int a = 0; a < 3; ++a)
        for (int b = a; b < 3; ++b)
            *ten++ += w * p[a] * p[b];
}

/// With the distance from the foot along the segment as x = D sinh(u), the integrand is a power of cosh(u):
/// smooth however near v is. The foot of v, where it peaks, parts the range in two. A place is p = foot + x
/// times the direction, so three sums of w, w x and w x^2 are all that is needed. Places of the quadrature
/// lie in pairs about the middle m of the range: exp(m + h) and exp(m - h) are two products.
void add_segment(const Segment& segment, double least, double size, double alpha, double* ten)
{
    const double D = std::max(segment.distance, 1e-12 * segment.length);
    const double begin = std::asinh(-segment.foot * segment.length / D),
                 end = std::asinh((1.0 - segment.foot) * segment.length / D);
    double sums[3] = {0.0, 0.0, 0.0};
    const auto place = [&](double exponential, double weight) {
        const double inverse = 1.0 / exponential;
        const double x = 0.5 * D * (exponential - inverse), away = 0.5 * D * (exponential + inverse);
        const double w = weight * away / size * decay(least, away * away, alpha);
        sums[0] += w;
        sums[1] += w * x;
        sums[2] += w * x * x;
    };
    const auto part = [&](double from, double to) {
        if (!(to > from))
            return;
        const double middle = std::exp(0.5 * (from + to)), half = 0.5 * (to - from);
        for (int k = 0; k < nodes / 2; ++k) {
            const double step = std::exp(half * half_places[k]);
            place(middle * step, half * half_weights[k]);
            place(middle / step, half * half_weights[k]);
        }
    };
    const double middle = std::clamp(0.0, begin, end);
    part(begin, middle);
    part(middle, end);
    const Vector3 foot = segment.from + segment.foot * segment.along, along = segment.along / segment.length;
    *ten++ += sums[0];
    for (int a = 0; a < 3; ++a)
        *ten++ += sums[0] * foot[a] + sums[1] * along[a];
    for (int a = 0; a < 3; ++a)
        for (int b = a; b < 3; ++b)
            *ten++ += sums[0] * foot[a] * foot[b] + sums[1] * (foot[a] * along[b] + along[a] * foot[b]) +
                      sums[2] * along[a] * along[b];
}

} // namespace

void mls_weights(const HandlePoints& handles, const MlsElements& elements, double alpha, const Vector3& v,
                 double* numbers)
{
    const Points& points = handles.points();
    const auto relative = [&](int i) -> Vector3 { return points.row(i).transpose() - v; };
    std::fill_n(numbers, elements.numbers(), 0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const int i : elements.points)
        least = std::min(least, relative(i).squaredNorm());
    for (const int h : elements.groups)
        for (int i = handles.begin(h); i < handles.begin(h + 1); ++i)
            least = std::min(least, relative(i).squaredNorm());
    for (const auto& [a, b] : elements.segments)
        least = std::min(least, Segment(points.row(a), points.row(b), v).least_square());
    const double touching = on_segment * handles.size() * on_segment * handles.size();
    const bool on = least <= (elements.segments.empty() ? 0.0 : touching);
    const auto is_there = [&](int i) { return relative(i).squaredNorm() <= least; };
    const auto is_full = [&](int i) { return is_there(i) && handles.weight(i) == 1.0; };
    const auto touches = [&](const std::array<int, 2>& ends) {
        return Segment(points.row(ends[0]), points.row(ends[1]), v).least_square() <= touching;
    };
    bool full = handles.all_full();
    if (on && !full) {
        full =
            std::ranges::any_of(elements.points, is_full) || std::ranges::any_of(elements.segments, touches);
        for (const int h : elements.groups)
            for (int i = handles.begin(h); i < handles.begin(h + 1); ++i)
                full = full || is_full(i);
    }
    // What a point counts if v lies on elements.
    const auto there = [&](int i) {
        const double weight = handles.weight(i);
        return is_there(i) && (!full || weight == 1.0) ? weight : 0.0;
    };
    double* to = numbers;
    for (const int i : elements.points)
        *to++ = on ? there(i) : handles.weight(i) * decay(least, relative(i).squaredNorm(), alpha);
    for (const int h : elements.groups) {
        const double share = 1.0 / (handles.begin(h + 1) - handles.begin(h));
        for (int i = handles.begin(h); i < handles.begin(h + 1); ++i) {
            const Vector3 p = relative(i);
            if (!on)
                add(to, share * handles.weight(i) * decay(least, p.squaredNorm(), alpha), p);
            else
                *to = std::max(*to, there(i));
        }
        to += 10;
    }
    for (const auto& [a, b] : elements.segments) {
        if (!on) {
            add_segment({points.row(a), points.row(b), v}, least, handles.size(), alpha, to);
            const double weight = 0.5 * (handles.weight(a) + handles.weight(b));
            std::for_each(to, to + 10, [weight](double& number) { number *= weight; });
        } else if (touches({a, b})) {
            *to = 1.0;
        }
        to += 10;
    }
    double sum = 0.0;
    const auto alone = elements.points.size();
    for (std::size_t k = 0; k < alone; ++k)
        sum += numbers[k];
    for (auto k = static_cast<int>(alone); k < elements.numbers(); k += 10)
        sum += numbers[k];
    for (int k = 0; k < elements.numbers(); ++k)
        numbers[k] /= sum;
}

} // namespace sinew
