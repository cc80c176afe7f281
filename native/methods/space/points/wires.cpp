// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/wires.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/space/points/wires/wire_kernels.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace sinew {

namespace {

constexpr double pi = 3.14159265358979323846;

/// One value per curve.
std::vector<double> per_curve(std::vector<double> values, std::size_t curves, const char* name, double least,
                              double most)
{
    if (values.size() == 1)
        values.resize(curves, values.front());
    if (values.size() != curves)
        throw InvalidOption(std::string(name) + ": give one number, or one for each of the " +
                            std::to_string(curves) + " curves");
    for (std::size_t k = 0; k < curves; ++k)
        if (!(std::isfinite(values[k]) && values[k] >= least && values[k] <= most))
            throw InvalidOption(std::string(name) + " of curve " + std::to_string(k) + " is out of range");
    return values;
}

} // namespace

Wires::Wires(Points reference, const WireOptions& options)
    : SpaceMethod("curves"), reference_(std::move(reference)), options_(options)
{
    std::vector<int> bad;
    for (int v = 0; v < reference_.rows(); ++v)
        if (!reference_.row(v).allFinite())
            bad.push_back(v);
    if (!bad.empty())
        throw InvalidConstraint("samples " + list_some(bad) + " of the curves are not finite",
                                Error::Element::vertex, bad);
    require_valid(options);
    if (options_.counts.empty())
        options_.counts = {static_cast<int>(reference_.rows())};
    add_curves();
    check_lengths();
    find_neighbours();
}

void Wires::add_curves()
{
    const std::size_t count = options_.counts.size();
    constexpr double tiny = 1e-300, huge = 1e300;
    options_.radius = per_curve(options_.radius, count, "radius", tiny, huge);
    options_.scale = per_curve(options_.scale, count, "scale", -huge, huge);
    options_.rotation = per_curve(options_.rotation, count, "rotation", 0.0, 1.0);
    if (options_.closed.size() <= 1)
        options_.closed.resize(count, !options_.closed.empty() && options_.closed.front());
    if (options_.closed.size() != count)
        throw InvalidOption("closed: give one flag, or one for each of the " + std::to_string(count) +
                            " curves");
    if (options_.domain.rows() != 0 && options_.domain.rows() != reference_.rows())
        throw InvalidOption("domain: give one sample for each of the " + std::to_string(reference_.rows()) +
                            " samples of the curves, or none");
    int begin = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const int samples = options_.counts[k], end = begin + samples;
        if (samples < 2 || end > reference_.rows())
            throw InvalidOption("counts: curve " + std::to_string(k) + " needs at least two samples, and " +
                                std::to_string(reference_.rows()) + " are given for all curves");
        const auto rows = reference_.middleRows(begin, samples);
        Curve curve{.begin = begin,
                    .end = end,
                    .closed = options_.closed[k],
                    .has_domain = false,
                    .radius = options_.radius[k],
                    .scale = options_.scale[k],
                    .rotation = options_.rotation[k],
                    .reach = options_.radius[k],
                    .low = rows.colwise().minCoeff(),
                    .high = rows.colwise().maxCoeff()};
        if (options_.domain.rows() != 0 &&
            !options_.domain.middleRows(begin, samples).array().isNaN().all()) {
            const auto limits = options_.domain.middleRows(begin, samples);
            if (!limits.allFinite())
                throw InvalidOption("domain: samples of curve " + std::to_string(k) + " are not finite");
            curve.has_domain = true;
            curve.reach = std::max(curve.reach, (limits - rows).rowwise().norm().maxCoeff());
        }
        curves_.push_back(curve);
        begin = end;
    }
    if (begin != reference_.rows())
        throw InvalidOption("counts: " + std::to_string(begin) + " samples are counted, and " +
                            std::to_string(reference_.rows()) + " are given");
}

void Wires::check_lengths() const
{
    const double size = reference_.size() ? reference_.cwiseAbs().maxCoeff() : 0.0;
    std::vector<int> without;
    for (std::size_t k = 0; k < curves_.size(); ++k)
        if (!((curves_[k].high - curves_[k].low).norm() > 1e-12 * size))
            without.push_back(static_cast<int>(k));
    if (!without.empty())
        throw InvalidConstraint("curves " + list_some(without) + " have no length", Error::Element::handle,
                                without);
}

void Wires::find_neighbours()
{
    before_.resize(static_cast<std::size_t>(reference_.rows()));
    after_ = before_;
    for (const Curve& curve : curves_)
        for (int v = curve.begin; v < curve.end; ++v) {
            const auto walk = [&](int step) {
                for (int at = v;;) {
                    int next = at + step;
                    if (curve.closed)
                        next = next < curve.begin ? curve.end - 1 : next == curve.end ? curve.begin : next;
                    if (next < curve.begin || next == curve.end || next == v)
                        return v;
                    at = next;
                    if (reference_.row(at) != reference_.row(v))
                        return at;
                }
            };
            before_[static_cast<std::size_t>(v)] = walk(-1);
            after_[static_cast<std::size_t>(v)] = walk(1);
        }
}

void Wires::add_contact(const Curve& curve, const Vector3& x, Found& found) const
{
    const Vector3 outside = (curve.low - x).cwiseMax(x - curve.high).cwiseMax(0.0);
    if (outside.norm() >= curve.reach)
        return;
    std::vector<Near>& segments = found.segments;
    segments.clear();
    double nearest = curve.reach * curve.reach;
    const double factor = (1.0 + options_.smoothing) * (1.0 + options_.smoothing);
    for (int v = curve.begin; v + 1 < curve.end || (curve.closed && v < curve.end); ++v) {
        const int w = v + 1 < curve.end ? v + 1 : curve.begin;
        const Vector3 a = reference_.row(v), side = reference_.row(w).transpose() - a;
        const double square_length = side.squaredNorm();
        if (square_length == 0.0)
            continue;
        const double along = std::clamp((x - a).dot(side) / square_length, 0.0, 1.0);
        const double square = (x - a - along * side).squaredNorm();
        if (square <= factor * nearest)
            segments.push_back({v, w, along, square, std::sqrt(square_length)});
        nearest = std::min(nearest, square);
    }
    const double window = (factor - 1.0) * nearest;
    const int first = static_cast<int>(found.shares.size());
    double sum = 0.0;
    const auto add = [&](int sample, double share) {
        for (int k = static_cast<int>(found.samples.size()) - 1; k >= first; --k)
            if (found.samples[static_cast<std::size_t>(k)] == sample) {
                found.shares[static_cast<std::size_t>(k)] += share;
                return;
            }
        found.samples.push_back(sample);
        found.shares.push_back(share);
    };
    for (const Near& segment : segments) {
        const double behind = segment.square - nearest;
        if (!(behind < window || behind == 0.0))
            continue;
        const double left = window > 0.0 ? 1.0 - behind / window : 1.0;
        const double weight = segment.length * left * left;
        if (weight == 0.0)
            continue;
        sum += weight;
        add(segment.from, weight * (1.0 - segment.along));
        add(segment.to, weight * segment.along);
    }
    const auto forget = [&] {
        found.samples.resize(static_cast<std::size_t>(first));
        found.shares.resize(static_cast<std::size_t>(first));
    };
    if (sum == 0.0)
        return forget(); // beyond the reach
    Vector3 middle = Vector3::Zero(), limit = Vector3::Zero();
    for (auto k = static_cast<std::size_t>(first); k < found.shares.size(); ++k) {
        found.shares[k] /= sum;
        middle += found.shares[k] * reference_.row(found.samples[k]).transpose();
        if (curve.has_domain)
            limit += found.shares[k] * options_.domain.row(found.samples[k]).transpose();
    }
    const double distance = std::sqrt(nearest);
    double radius = curve.radius;
    if (curve.has_domain) {
        limit -= middle;
        const double far = limit.norm(), apart = (x - middle).norm();
        const double cosine = far > 0.0 && apart > 0.0 ? limit.dot(x - middle) / (far * apart) : 0.0;
        if (cosine > 0.0)
            radius += (far - radius) * cosine * cosine;
    }
    const double t = distance / radius;
    if (!(t < 1.0))
        return forget();
    const double falloff = (1.0 - t * t) * (1.0 - t * t);
    found.contacts.push_back(
        {x - middle, falloff, (curve.scale - 1.0) * falloff, static_cast<int>(found.shares.size()) - first});
}

void Wires::add_contacts(const Vector3& x, Found& found) const
{
    for (const Curve& curve : curves_)
        add_contact(curve, x, found);
    found.begins.push_back(static_cast<int>(found.contacts.size()));
}

void Wires::append(const Found& part, Found& waiting, Contacts& all)
{
    const int before = all.begins.back();
    for (const int begin : part.begins)
        all.begins.push_back(before + begin);
    const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(waiting.contacts, part.contacts);
    add(waiting.samples, part.samples);
    add(waiting.shares, part.shares);
}

void Wires::pack(Found& waiting, bool end, Contacts& all)
{
    const int count = static_cast<int>(waiting.contacts.size()), packed = end ? count : count / 4 * 4;
    int begin = 0; // the first share of the next contact
    for (int first = 0; first < packed; first += 4) {
        int shares[4] = {}, begins[4] = {}, rows = 0;
        all.blocks.resize(all.blocks.size() + 20, 0.0);
        for (int lane = 0; lane < std::min(4, packed - first); ++lane) {
            const Contact& contact = waiting.contacts[static_cast<std::size_t>(first + lane)];
            const double values[5] = {contact.from.x(), contact.from.y(), contact.from.z(), contact.falloff,
                                      contact.stretch};
            for (int value = 0; value < 5; ++value)
                all.blocks.end()[4 * value + lane - 20] = values[value];
            begins[lane] = begin;
            begin += shares[lane] = contact.shares;
            rows = std::max(rows, contact.shares);
        }
        const auto sample = [&](int lane, int row) {
            return waiting.samples[static_cast<std::size_t>(begins[lane] + row)];
        };
        for (int row = 0; row < rows; ++row) {
            bool follows = row > 0;
            for (int lane = 0; lane < 4; ++lane)
                follows = follows && (row >= shares[lane] || sample(lane, row) == sample(lane, row - 1) + 1);
            if (!follows)
                all.rows.push_back(all.rows.back());
            ++all.rows.back();
            for (int lane = 0; lane < 4; ++lane) {
                const bool shared = row < shares[lane];
                if (!follows)
                    all.samples.push_back(shared ? sample(lane, row) : 0);
                all.shares.push_back(shared ? waiting.shares[static_cast<std::size_t>(begins[lane] + row)]
                                            : 0.0);
            }
        }
        all.firsts.push_back(static_cast<int>(all.rows.size()) - 1);
    }
    waiting.contacts.erase(waiting.contacts.begin(), waiting.contacts.begin() + packed);
    waiting.samples.erase(waiting.samples.begin(), waiting.samples.begin() + begin);
    waiting.shares.erase(waiting.shares.begin(), waiting.shares.begin() + begin);
}

void Wires::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    constexpr int slab = 1 << 16, grain = 1 << 10;
    const int count = static_cast<int>(points.rows());
    const auto bytes = [](const Contacts& made) {
        return static_cast<std::int64_t>(
            sizeof(int) * (made.begins.size() + made.firsts.size() + made.rows.size() + made.samples.size()) +
            sizeof(double) * (made.blocks.size() + made.shares.size()));
    };
    Contacts all;
    Found waiting;
    progress.tick(0.0, "finding the nearest curves");
    for (int first = 0; first < count; first += slab) {
        const int some = std::min(slab, count - first);
        std::vector<Found> parts(static_cast<std::size_t>((some + grain - 1) / grain));
        parallel_chunks(some, grain, [&](int begin, int end) {
            for (int i = begin; i < end; ++i)
                add_contacts(points.row(first + i), parts[static_cast<std::size_t>(begin / grain)]);
        });
        for (const Found& part : parts)
            append(part, waiting, all);
        pack(waiting, first + some == count, all);
        require_memory(bytes(all), "the wires");
        progress.tick(static_cast<double>(first + some) / count, "finding the nearest curves");
    }
    if (count == 0)
        progress.tick(1.0, "finding the nearest curves");
    report.weight_bytes = bytes(all);
    contacts_ = std::move(all);
}

Vector3 Wires::turn(const Curve& curve, int sample, PointsView control) const
{
    const int before = before_[static_cast<std::size_t>(sample)],
              after = after_[static_cast<std::size_t>(sample)];
    const auto tangent = [&](const auto& points) -> Vector3 {
        return (points.row(after) - points.row(before)).transpose().stableNormalized();
    };
    const Vector3 rest = tangent(reference_), now = tangent(control), axis = rest.cross(now);
    const double sine = axis.norm(), cosine = rest.dot(now);
    if (sine > 1e-12)
        return (curve.rotation * std::atan2(sine, cosine) / sine) * axis;
    if (cosine < 0.0) // turned round: any axis across will do
        return curve.rotation * pi * rest.unitOrthogonal();
    return Vector3::Zero();
}

AlignedVector<double> Wires::table(PointsView control) const
{
    int longest = 0; // a contact follows each sample of its curve at most once
    for (const Curve& curve : curves_)
        longest = std::max(longest, curve.end - curve.begin);
    AlignedVector<double> rows(8 * static_cast<std::size_t>(control.rows() + longest), 0.0);
    for (const Curve& curve : curves_)
        for (int v = curve.begin; v < curve.end; ++v) {
            double* const row = rows.data() + 8 * static_cast<std::size_t>(v);
            Vector3::Map(row) = (control.row(v) - reference_.row(v)).transpose();
            if (curve.rotation != 0.0)
                Vector3::Map(row + 4) = turn(curve, v, control);
        }
    return rows;
}

void Wires::displace(PointsView control, PointsView base, PositionsOut out) const
{
    if (control.rows() != reference_.rows())
        throw InvalidConstraint("the curves have " + std::to_string(reference_.rows()) + " samples, and " +
                                std::to_string(control.rows()) + " are given");
    if (!all_finite(control))
        throw InvalidConstraint("a sample of the curves is not finite");
    const AlignedVector<double> rows = table(control);
    const WireContacts contacts{contacts_.firsts.data(), contacts_.rows.data(), contacts_.samples.data(),
                                contacts_.shares.data(), contacts_.blocks.data()};
    const double m = options_.exponent;
    /// The move of a point by some contacts, whose moves are rows of four numbers.
    const auto blended = [m](const double* moves, int count) -> Vector3 {
        if (count == 1)
            return Vector3::Map(moves);
        double longest = 0.0;
        for (int k = 0; k < count; ++k)
            longest = std::max(longest, Vector3::Map(moves + 4 * k).squaredNorm());
        if (longest == 0.0)
            return Vector3::Zero();
        Vector3 sum = Vector3::Zero();
        double weights = 0.0;
        for (int k = 0; k < count; ++k) {
            const auto one = Vector3::Map(moves + 4 * k);
            const double share = std::sqrt(one.squaredNorm() / longest);
            const double weight = m == 1.0 ? share : std::pow(share, m);
            sum += weight * one;
            weights += weight;
        }
        return sum / weights;
    };
    std::visit(
        [&](auto* positions) {
            using Number = std::remove_pointer_t<decltype(positions)>;
            parallel_chunks(static_cast<int>(base.rows()), 1 << 10, [&](int begin, int end) {
                const int first = contacts_.begins[static_cast<std::size_t>(begin)];
                const int last = contacts_.begins[static_cast<std::size_t>(end)];
                const int block = first / 4, blocks = last > first ? (last + 3) / 4 - block : 0;
                AlignedVector<double> moves(16 * static_cast<std::size_t>(blocks));
                widest_kernels<WireKernels>().moves(contacts, rows.data(), block, blocks, moves.data());
                for (int i = begin; i < end; ++i) {
                    const int from = contacts_.begins[static_cast<std::size_t>(i)];
                    const int count = contacts_.begins[static_cast<std::size_t>(i) + 1] - from;
                    Vector3 x = base.row(i).transpose();
                    if (count)
                        x += blended(moves.data() + 4 * static_cast<std::size_t>(from - 4 * block), count);
                    for (int k = 0; k < 3; ++k)
                        positions[3 * static_cast<std::size_t>(i) + k] = static_cast<Number>(x[k]);
                }
            });
        },
        out);
}

std::vector<std::string> Wires::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const Wires&>(former);
    return changed(options_, other.options_,
                   names_of({{"curves", !same(reference_, other.reference_) ||
                                            options_.counts != other.options_.counts}}));
}

void Wires::swap_weights(SpaceMethod& other) { std::swap(contacts_, static_cast<Wires&>(other).contacts_); }

} // namespace sinew
