// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/quad_patches.h"

#include "native/core/simd/aligned.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/space/cage/closed_forms/gauss_rules.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace sinew {

namespace {

constexpr double quarter = 0.079577471545947668; // 1 / (4 pi)
constexpr double sign_s[4] = {-1.0, 1.0, 1.0, -1.0}, sign_t[4] = {-1.0, -1.0, 1.0, 1.0};
/// A quad is no patch if its normal at a corner, times that of the middle, is less than this share of the
/// latter squared.
constexpr double least_turn = 1e-3;
/// A patch without area is left out, as CageGeometry does with triangles.
constexpr double least_height = 1e-8;

const auto V = [](const double* v) { return Vector3::Map(v); };

/// Half the sides of a quad and its twist.
struct Sides
{
    Vector3 along, across, twist;

    Sides(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d)
    {
        along = 0.25 * ((b - a) + (c - d));
        across = 0.25 * ((d - a) + (c - b));
        twist = 0.25 * ((a - b) + (c - d));
    }
    Vector3 middle() const { return along.cross(across); }
    Vector3 along_part() const { return along.cross(twist); }
    Vector3 across_part() const { return twist.cross(across); }
};

/// Rules for points that are far enough: how far the middle of a line is, in half lengths.
struct FarRule
{
    double from;
    GaussRule rule;
};
constexpr FarRule far_rules[] = {{9.0, gauss_rule(4)}, {5.5, gauss_rule(5)},  {4.0, gauss_rule(6)},
                                 {2.8, gauss_rule(8)}, {2.1, gauss_rule(10)}, {1.75, gauss_rule(12)}};
constexpr std::size_t far_rule_count = 6;
constexpr GaussRule panel_rule = gauss_rule(12);
/// No singularity lies inside the ellipse around a panel whose half axes have this sum.
constexpr double panel_ellipse = 3.2;

/// The rule with the fewest points; far_rule_count if the place is near.
std::size_t rule_for(double square, const std::array<double, far_rule_count>& reach)
{
    std::size_t rule = 0;
    for (const double from : reach)
        rule += square < from ? 1 : 0;
    return rule;
}

/// The sum of the half axes of the ellipse around [-1, 1] on which w lies.
double ellipse(const std::complex<double>& w)
{
    const auto length = [](double x, double y) { return std::sqrt(x * x + y * y); };
    const double sum = 0.5 * (length(w.real() - 1.0, w.imag()) + length(w.real() + 1.0, w.imag()));
    return sum + std::sqrt(std::max(0.0, sum * sum - 1.0));
}

} // namespace

std::vector<char> QuadPatches::faces(const Cage& cage)
{
    std::vector<char> found(static_cast<std::size_t>(cage.rest().face_count()), 0);
    for (int f = 0; f < cage.rest().face_count(); ++f) {
        const auto face = cage.rest().face(f);
        if (face.size() != 4)
            continue;
        const SurfaceMesh& mesh = cage.rest();
        const Sides sides(mesh.point(face[0]), mesh.point(face[1]), mesh.point(face[2]), mesh.point(face[3]));
        const Vector3 middle = sides.middle();
        const double square = middle.squaredNorm();
        double longest = 0.0, least = square;
        for (int k = 0; k < 4; ++k) {
            const Vector3 corner = middle + sign_s[k] * sides.along_part() + sign_t[k] * sides.across_part();
            least = std::min(least, corner.dot(middle));
            longest = std::max(longest, (sides.along + sign_t[k] * sides.twist).norm());
            longest = std::max(longest, (sides.across + sign_s[k] * sides.twist).norm());
        }
        found[static_cast<std::size_t>(f)] =
            least > least_turn * square && std::sqrt(square) > least_height * cage.size() * longest;
    }
    return found;
}

QuadPatches::QuadPatches(const Cage& cage, const CageGeometry& geometry, const std::vector<char>& faces)
{
    for (int f = 0; f < static_cast<int>(faces.size()); ++f) {
        if (!faces[static_cast<std::size_t>(f)])
            continue;
        const auto face = cage.rest().face(f);
        const auto corner = [&](int k) -> Vector3 {
            return geometry.normalized(cage.rest().point(face[static_cast<std::size_t>(k)]));
        };
        const Sides sides(corner(0), corner(1), corner(2), corner(3));
        QuadPatch patch;
        Vector3::Map(patch.centre) = 0.25 * (corner(0) + corner(1) + corner(2) + corner(3));
        Vector3::Map(patch.along) = sides.along;
        Vector3::Map(patch.across) = sides.across;
        Vector3::Map(patch.twist) = sides.twist;
        Vector3::Map(patch.normal[0]) = sides.middle();
        Vector3::Map(patch.normal[1]) = sides.along_part();
        Vector3::Map(patch.normal[2]) = sides.across_part();
        patches_.push_back(patch);
        corners_.push_back({face[0], face[1], face[2], face[3]});
        const double along = sides.along.norm(), across = sides.across.norm(), twist = sides.twist.norm();
        Reach reach{along + across + twist, {}, {}};
        for (std::size_t k = 0; k < far_rule_count; ++k) {
            const double of_s = far_rules[k].from * (along + twist) + across,
                         of_t = far_rules[k].from * (across + twist) + along;
            reach.of_s[k] = of_s * of_s;
            reach.of_t[k] = of_t * of_t;
        }
        reaches_.push_back(reach);
        faces_.push_back(f);
    }
}

Vector3 QuadPatches::point(int q, double s, double t) const
{
    const QuadPatch& patch = patches_[static_cast<std::size_t>(q)];
    return V(patch.centre) + s * (V(patch.along) + t * V(patch.twist)) + t * V(patch.across);
}

Vector3 QuadPatches::normal(const Place& place) const
{
    const QuadPatch& patch = patches_[static_cast<std::size_t>(place.q)];
    return (V(patch.normal[0]) + place.s * V(patch.normal[1]) + place.t * V(patch.normal[2]))
        .stableNormalized();
}

QuadPatches::Place QuadPatches::closest(int q, const Vector3& x) const
{
    const QuadPatch& patch = patches_[static_cast<std::size_t>(q)];
    const Vector3 along = V(patch.along), across = V(patch.across), twist = V(patch.twist);
    const auto clamped = [](double value) { return std::clamp(value, -1.0, 1.0); };
    const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
    const auto square = [&](double s, double t) { return (point(q, s, t) - x).squaredNorm(); };

    // Newton's method, with s or t held where it is at its end and would leave.
    const auto descend = [&](double& s, double& t) {
        double least = square(s, t);
        for (int step = 0; step < 40; ++step) {
            const Vector3 r = point(q, s, t) - x, to_s = along + t * twist, to_t = across + s * twist;
            const double gs = r.dot(to_s), gt = r.dot(to_t), ss = to_s.squaredNorm(), tt = to_t.squaredNorm();
            const bool holds_s = (s >= 1.0 && gs < 0.0) || (s <= -1.0 && gs > 0.0);
            const bool holds_t = (t >= 1.0 && gt < 0.0) || (t <= -1.0 && gt > 0.0);
            double ds = holds_s ? 0.0 : -share(gs, ss), dt = holds_t ? 0.0 : -share(gt, tt);
            if (!holds_s && !holds_t) {
                const double flat = to_s.dot(to_t), mixed = flat + r.dot(twist);
                const double used = ss * tt - mixed * mixed > 1e-3 * ss * tt ? mixed : flat;
                const double det = ss * tt - used * used;
                if (det > 1e-12 * ss * tt) {
                    ds = (used * gt - tt * gs) / det;
                    dt = (used * gs - ss * gt) / det;
                }
            }
            bool moved = false;
            double length = 1.0;
            for (int half = 0; half < 10 && !moved; ++half, length *= 0.5) {
                const double next_s = clamped(s + length * ds), next_t = clamped(t + length * dt);
                const double value = square(next_s, next_t);
                moved = value < least;
                if (moved)
                    s = next_s, t = next_t, least = value;
            }
            if (!moved)
                break;
        }
        return least;
    };

    const Vector3 from = x - V(patch.centre);
    const double aa = along.squaredNorm(), cc = across.squaredNorm(), ac = along.dot(across);
    const double det = aa * cc - ac * ac;
    double s = 0.0, t = 0.0;
    if (det > 0.0) {
        s = clamped((cc * from.dot(along) - ac * from.dot(across)) / det);
        t = clamped((aa * from.dot(across) - ac * from.dot(along)) / det);
    }
    double best = descend(s, t);
    // A patch that turns may have a second closest place; its edges are looked at, too.
    double edge_s = 0.0, edge_t = 0.0, edge_best = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {
        const double end = k % 2 ? 1.0 : -1.0;
        const Vector3 side = k < 2 ? Vector3(along + end * twist) : Vector3(across + end * twist);
        const Vector3 middle = V(patch.centre) + end * (k < 2 ? across : along);
        const double at = clamped(share((x - middle).dot(side), side.squaredNorm()));
        const double value = (middle + at * side - x).squaredNorm();
        if (value < edge_best) {
            edge_best = value;
            edge_s = k < 2 ? at : end;
            edge_t = k < 2 ? end : at;
        }
    }
    if (edge_best < best) {
        const double found = descend(edge_s, edge_t);
        if (found < best)
            s = edge_s, t = edge_t, best = found;
    }
    return {q, s, t, std::sqrt(best)};
}

QuadPatches::Place QuadPatches::closest(const Vector3& x) const
{
    Place found;
    for (int q = 0; q < count(); ++q) {
        const double least = (x - V(patches_[static_cast<std::size_t>(q)].centre)).norm() -
                             reaches_[static_cast<std::size_t>(q)].radius;
        if (found.q >= 0 && least >= found.distance)
            continue;
        const Place place = closest(q, x);
        if (found.q < 0 || place.distance < found.distance)
            found = place;
    }
    return found;
}

/// Nodes over t for one point near a patch, and what the kernel says about them.
struct QuadPatches::Panels
{
    AlignedVector<double> places, integrals;
    std::vector<double> weights;
    std::complex<double> poles[3];
    int pole_count = 0;
    double scale = 1.0;

    void add_pole(double real, double imaginary)
    {
        poles[pole_count++] = std::asinh(std::complex<double>(real, imaginary) / scale);
    }
    void fill(double low, double high, int depth)
    {
        const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
        bool fits = half < 1.1; // the nearest ones to x are at an imaginary part of pi / 2
        for (int k = 0; k < pole_count && fits; ++k)
            fits = ellipse((poles[k] - middle) / half) >= panel_ellipse;
        if (!fits && depth < 40) {
            fill(low, middle, depth + 1);
            fill(middle, high, depth + 1);
            return;
        }
        for (int k = 0; k < panel_rule.count; ++k) {
            const double xi = middle + half * panel_rule.node(k);
            places.push_back(scale * std::sinh(xi));
            weights.push_back(half * panel_rule.weight(k) * scale * std::cosh(xi));
        }
    }
};

void QuadPatches::integrate_near(const Place& place, const Vector3& x, Panels& panels, double* moments) const
{
    const QuadPatch& patch = patches_[static_cast<std::size_t>(place.q)];
    const Vector3 twist = V(patch.twist), along = V(patch.along) + place.t * twist,
                  across = V(patch.across) + place.s * twist, offset = x - point(place.q, place.s, place.t);
    NearPatch near;
    Vector3::Map(near.along) = along;
    Vector3::Map(near.across) = across;
    Vector3::Map(near.twist) = twist;
    Vector3::Map(near.offset) = offset;
    near.low = -1.0 - place.s;
    near.high = 1.0 - place.s;
    near.height[0] = -offset.dot(along.cross(across));
    near.height[1] = -offset.dot(V(patch.normal[2]));
    near.lean[0] = -offset.dot(V(patch.normal[1]));
    near.lean[1] = across.dot(V(patch.normal[1]));

    const double speed = std::max(along.cross(across).norm() / std::max(along.norm(), 1e-30), 1e-12);
    panels.places.clear();
    panels.weights.clear();
    panels.pole_count = 0;
    panels.scale = std::clamp(offset.norm() / speed, 1e-14, 1e3);
    // Where the ends of the lines meet x.
    for (const double end : {near.low, near.high}) {
        const Vector3 from = end * along - offset, step = across + end * twist;
        const double square = step.squaredNorm();
        if (square > 0.0)
            panels.add_pole(-from.dot(step) / square, from.cross(step).norm() / square);
    }
    // Where a line itself meets x, between its ends.
    const Vector3 first = -offset.cross(along), second = across.cross(along) - offset.cross(twist);
    const double linear = first.dot(second);
    const double square = second.squaredNorm() + 2.0 * first.dot(across.cross(twist));
    if (square > 0.0) {
        const double real = -linear / square;
        const Vector3 to = along + real * twist;
        const double foot = -(real * across - offset).dot(to) / std::max(to.squaredNorm(), 1e-300);
        if (foot > near.low && foot < near.high)
            panels.add_pole(real, std::sqrt(std::max(0.0, square * first.squaredNorm() - linear * linear)) /
                                      square);
    }
    panels.fill(std::asinh((-1.0 - place.t) / panels.scale), std::asinh((1.0 - place.t) / panels.scale), 0);

    const std::size_t used = panels.weights.size(), wide = most_quad_lanes;
    panels.places.resize((used + wide - 1) / wide * wide, panels.places.back());
    const std::size_t stride = panels.places.size();
    panels.integrals.resize(4 * stride);
    widest_kernels<QuadKernels>().lines(near, panels.places.data(), static_cast<int>(stride),
                                        panels.integrals.data());
    std::fill(moments, moments + 7, 0.0);
    for (std::size_t k = 0; k < used; ++k) {
        const double w = quarter * panels.weights[k], t = place.t + panels.places[k];
        const double m0 = w * panels.integrals[k], m1 = place.s * m0 + w * panels.integrals[stride + k],
                     q0 = w * panels.integrals[2 * stride + k],
                     q1 = place.s * q0 + w * panels.integrals[3 * stride + k];
        const double parts[7] = {m0, m1, t * m0, t * m1, q0, q1, t * q0};
        for (int i = 0; i < 7; ++i)
            moments[i] += parts[i];
    }
}

void QuadPatches::add(const std::vector<Vector3>& points, int first, MatrixX& weights, VectorX& winding,
                      std::vector<Place>& near) const
{
    const QuadKernels& kernels = widest_kernels<QuadKernels>();
    const std::size_t lanes = static_cast<std::size_t>(kernels.lanes);
    // Points with the same two rules are taken together; the rules depend on point and patch alone.
    std::vector<int> groups[far_rule_count * far_rule_count];
    alignas(64) double some[3 * most_quad_lanes], sums[7 * most_quad_lanes];
    double alone[7];
    Panels panels;
    Eigen::Matrix<double, Eigen::Dynamic, 7> moments(static_cast<Eigen::Index>(points.size()), 7);
    for (int q = 0; q < count(); ++q) {
        const QuadPatch& patch = patches_[static_cast<std::size_t>(q)];
        const Reach& reach = reaches_[static_cast<std::size_t>(q)];
        for (std::vector<int>& group : groups)
            group.clear();
        for (int i = 0; i < static_cast<int>(points.size()); ++i) {
            const Vector3& x = points[static_cast<std::size_t>(i)];
            const double square = (x - V(patch.centre)).squaredNorm();
            const std::size_t s = rule_for(square, reach.of_s), t = rule_for(square, reach.of_t);
            if (s < far_rule_count && t < far_rule_count) {
                groups[far_rule_count * s + t].push_back(i);
                continue;
            }
            const Place place = closest(q, x);
            Place& nearest = near[static_cast<std::size_t>(i)];
            if (nearest.q < 0 || place.distance < nearest.distance)
                nearest = place;
            integrate_near(place, x, panels, alone);
            moments.row(i) = Eigen::Map<Eigen::Matrix<double, 1, 7>>(alone);
        }
        for (std::size_t g = 0; g < far_rule_count * far_rule_count; ++g) {
            const std::vector<int>& group = groups[g];
            const GaussRule &s = far_rules[g / far_rule_count].rule, &t = far_rules[g % far_rule_count].rule;
            for (std::size_t begin = 0; begin < group.size(); begin += lanes) {
                const std::size_t used = std::min(lanes, group.size() - begin);
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    const Vector3& x =
                        points[static_cast<std::size_t>(group[begin + std::min(lane, used - 1)])];
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        some[axis * lanes + lane] = x[static_cast<Eigen::Index>(axis)];
                }
                kernels.moments(patch, some, s.pairs, s.count, t.pairs, t.count, sums);
                for (std::size_t lane = 0; lane < used; ++lane)
                    for (std::size_t k = 0; k < 7; ++k)
                        moments(group[begin + lane], static_cast<Eigen::Index>(k)) =
                            quarter * sums[k * lanes + lane];
            }
        }
        winding += moments.col(0);
        for (std::size_t k = 0; k < 4; ++k)
            weights.col(corners_[static_cast<std::size_t>(q)][k]) +=
                0.25 * ((moments.col(0) + sign_s[k] * moments.col(1)) +
                        sign_t[k] * (moments.col(2) + sign_s[k] * moments.col(3)));
        weights.middleCols(first + 3 * q, 3) = moments.rightCols(3);
    }
}

void QuadPatches::represent(const Place& place, double sum, const Vector3& vector, int first,
                            Eigen::Ref<Eigen::RowVectorXd> row) const
{
    const QuadPatch& patch = patches_[static_cast<std::size_t>(place.q)];
    // Where the sides at a corner are nearly parallel, there is no frame; a little inside there is one.
    double s = place.s, t = place.t;
    Matrix3 frame;
    const auto look = [&] {
        frame.col(0) = V(patch.along) + t * V(patch.twist);
        frame.col(1) = V(patch.across) + s * V(patch.twist);
        frame.col(2) = frame.col(0).cross(frame.col(1));
        return frame.col(2).norm() > 1e-3 * frame.col(0).norm() * frame.col(1).norm();
    };
    for (int k = 0; k < 40 && !look(); ++k)
        s *= 0.9, t *= 0.9;
    const Vector3 parts = frame.fullPivLu().solve(vector - sum * point(place.q, s, t));
    for (int k = 0; k < 4; ++k)
        row[corners_[static_cast<std::size_t>(place.q)][static_cast<std::size_t>(k)]] +=
            0.25 *
            (sum * (1.0 + sign_s[k] * s) * (1.0 + sign_t[k] * t) +
             parts[0] * sign_s[k] * (1.0 + sign_t[k] * t) + parts[1] * sign_t[k] * (1.0 + sign_s[k] * s));
    // The third part is a share of the normal, which has the parts 1, s, t.
    row[first + 3 * place.q] += parts[2];
    row[first + 3 * place.q + 1] += parts[2] * s;
    row[first + 3 * place.q + 2] += parts[2] * t;
}

void QuadPatches::controls(PointsView vertices, Eigen::Ref<Points> controls) const
{
    constexpr double node = 0.57735026918962576; // Gauss's rule with 2 x 2 points
    for (int q = 0; q < count(); ++q) {
        const QuadPatch& rest = patches_[static_cast<std::size_t>(q)];
        const std::array<int, 4>& v = corners_[static_cast<std::size_t>(q)];
        Sides to(vertices.row(v[0]), vertices.row(v[1]), vertices.row(v[2]), vertices.row(v[3]));
        const double scale = std::max({to.along.cwiseAbs().maxCoeff(), to.across.cwiseAbs().maxCoeff(),
                                       to.twist.cwiseAbs().maxCoeff()});
        if (!(scale > 0.0)) {
            controls.middleRows(3 * q, 3).setZero();
            continue;
        }
        to.along /= scale, to.across /= scale, to.twist /= scale; // fourth powers follow
        const Vector3 parts[3] = {to.middle(), to.along_part(), to.across_part()};
        double stretch = 0.0, area = 0.0;
        for (int k = 0; k < 4; ++k) {
            const double s = node * sign_s[k], t = node * sign_t[k];
            const Vector3 u = V(rest.along) + t * V(rest.twist), v = V(rest.across) + s * V(rest.twist),
                          to_u = to.along + t * to.twist, to_v = to.across + s * to.twist;
            const double square = to_u.squaredNorm() * v.squaredNorm() - 2.0 * to_u.dot(to_v) * u.dot(v) +
                                  to_v.squaredNorm() * u.squaredNorm();
            stretch += std::sqrt(std::max(0.0, 0.5 * square));
            area += (parts[0] + s * parts[1] + t * parts[2]).norm();
        }
        const double factor = area > 1e-14 ? scale * stretch / area : 0.0;
        for (int k = 0; k < 3; ++k)
            controls.row(3 * q + k) = factor * parts[k].transpose();
    }
}

} // namespace sinew
