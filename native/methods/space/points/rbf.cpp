// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/points/rbf.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/core/simd/product_of_eight.h"
#include "native/core/space/space_order.h"
#include "native/methods/space/points/rbf/near_centres.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace sinew {

namespace {

/// Up to so many points, a dense system is solved faster than centres are chosen.
constexpr int few_points = 400;
/// More take many seconds to bind, and each frame some.
constexpr int many_points = 3000;

/// Places farther away, in the unit box, count as so far: phi of them would be infinite.
constexpr double farthest = 1e30;

int degree_of(const RbfOptions& options)
{
    switch (options.function) {
    case RbfFunction::triharmonic:
        return std::clamp(options.degree, 1, 2);
    case RbfFunction::biharmonic:
        return std::clamp(options.degree, 0, 1);
    default:
        return std::min(options.degree, 1);
    }
}

/// Points closer than this, in the unit box, are one centre: phi of two would be equal up to rounding.
double least_distance(const RbfBasis& basis)
{
    switch (basis.function) {
    case RbfFunction::triharmonic:
        return 1e-4;
    case RbfFunction::biharmonic:
        return 1e-9;
    case RbfFunction::wendland_c0:
        return 1e-9 / basis.scale;
    case RbfFunction::wendland_c2:
        return 1e-4 / basis.scale;
    case RbfFunction::wendland_c4:
        return 2e-3 / basis.scale;
    }
    return 0.0;
}

/// Points that stand for those near them.
struct Places
{
    Points centres;         ///< (c, 3)
    std::vector<int> of;    ///< the centre of each point
    std::vector<int> sizes; ///< how many points each centre stands for
    std::vector<double> weights; ///< of each point among those of its centre
    std::vector<double> totals;  ///< of the weights of each centre

    /// \param points  those of `handles`, scaled.
    Places(const Points& points, double reach, const HandlePoints& handles);
    /// (c, k) the means of values (n, k) of the points.
    RowMatrix means(const RowMatrix& values) const
    {
        RowMatrix sums = RowMatrix::Zero(centres.rows(), values.cols());
        for (std::size_t i = 0; i < of.size(); ++i)
            sums.row(of[i]) += weights[i] * values.row(static_cast<Eigen::Index>(i));
        for (std::size_t c = 0; c < sizes.size(); ++c)
            sums.row(static_cast<Eigen::Index>(c)) /= totals[c];
        return sums;
    }
};

Places::Places(const Points& points, double reach, const HandlePoints& handles)
    : of(static_cast<std::size_t>(points.rows()), -1)
{
    std::vector<int> order(of.size()), firsts;
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int i) { return points(i, 0); });
    const NearCentres near(points, reach);
    for (const int i : order) {
        if (of[static_cast<std::size_t>(i)] >= 0)
            continue;
        const int own = static_cast<int>(firsts.size());
        firsts.push_back(i);
        sizes.push_back(1);
        of[static_cast<std::size_t>(i)] = own;
        const Vector3 at = points.row(i).transpose();
        near.visit(at, at, [&](int begin, int end) {
            for (int k = begin; k < end; ++k)
                if (int& other = of[static_cast<std::size_t>(near.order()[k])];
                    other < 0 && (near.centres().row(k).transpose() - at).norm() <= reach) {
                    other = own;
                    ++sizes.back();
                }
        });
    }
    centres.resize(static_cast<Eigen::Index>(firsts.size()), 3);
    for (std::size_t c = 0; c < firsts.size(); ++c)
        centres.row(static_cast<Eigen::Index>(c)) = points.row(firsts[c]);
    std::vector<char> is_full(firsts.size(), 0);
    for (std::size_t i = 0; i < of.size(); ++i)
        is_full[of[i]] |= static_cast<char>(handles.weight(static_cast<int>(i)) == 1.0);
    totals.assign(firsts.size(), 0.0);
    for (std::size_t i = 0; i < of.size(); ++i) {
        const double weight = handles.weight(static_cast<int>(i));
        weights.push_back(is_full[of[i]] && weight < 1.0 ? 0.0 : weight);
        totals[of[i]] += weights.back();
    }
}

} // namespace

/// The centres, and what is computed of them.
struct Rbf::Solved
{
    std::unique_ptr<const Places> places; ///< of the handle points, in the unit box
    Points centres;                       ///< (c, 3) these places, or some of them
    Polynomials polynomials;
    RbfSystem system;             ///< if each handle is one point
    RbfCoefficients coefficients; ///< otherwise: of the columns of the control
    NearCentres near;
    /// The same as a table of three columns after the other: (columns / 3 rounded up, count + c, 3), of the
    /// polynomials and then of the centres in the order of `near`.
    std::vector<double> factors;
    double error = 0.0;
};

/// Up to eight points, in the unit box.
struct Rbf::Eight
{
    std::array<double, 24> places{}; ///< all x, all y, all z
    std::array<int, 8> points{};
    int count;
    Vector3 low, high; ///< their box

    /// \param order  of the points; empty for their own.
    Eight(const Rbf& rbf, const PointsView& all, const std::vector<int>& order, int first)
        : count(std::min(8, static_cast<int>(all.rows()) - first))
    {
        for (int i = 0; i < count; ++i) {
            points[i] = order.empty() ? first + i : order[first + i];
            for (int k = 0; k < 3; ++k)
                places[8 * k + i] = all(points[i], k);
        }
        for (int k = 0; k < 3; ++k) {
            const double corner = rbf.handles_.corner()[k], size = rbf.handles_.size();
            const auto along = std::span(places).subspan(8 * k, 8);
            for (double& x : along)
                x = std::clamp((x - corner) / size, -farthest, farthest);
            const auto [least, greatest] = std::ranges::minmax(along.first(count));
            low[k] = least;
            high[k] = greatest;
        }
    }
};

Rbf::Rbf(HandlePoints handles, const RbfOptions& options)
    : LinearSpaceMethod("handles", {options.precision, 0.0}), handles_(std::move(handles)), options_(options)
{
    require_valid(options);
    basis_ = {options.function, is_compact(options.function) ? 1.0 / options.radius : 1.0};
}

Rbf::~Rbf() = default;

double Rbf::reach() const
{
    return is_compact(basis_.function) ? options_.radius : std::numeric_limits<double>::infinity();
}

Points Rbf::centres() const
{
    const AccessLock shared = reading();
    if (!solved_)
        return {};
    return (handles_.size() * solved_->centres).rowwise() + handles_.corner().transpose();
}

double Rbf::error() const
{
    const AccessLock shared = reading();
    return solved_ ? solved_->error : 0.0;
}

double Rbf::prepare(PointsView points, const Progress& progress)
{
    if (solved_)
        return 0.0;
    // Values of phi for each point and centre take the rest of the time.
    const double c = handles_.point_count(),
                 own = c * c * c / (c * c * c + 40.0 * c * static_cast<double>(points.rows()) + 1.0);
    const Progress within([&](double fraction, const char* stage) {
        progress.tick(own * fraction, stage);
        return true;
    });
    auto solved = std::make_shared<Solved>();
    const Points scaled = (handles_.points().rowwise() - handles_.corner().transpose()) / handles_.size();
    solved->places = std::make_unique<const Places>(scaled, least_distance(basis_), handles_);
    const Points& places = solved->places->centres;
    solved->polynomials = Polynomials(places, degree_of(options_));
    if (handles_.all_single()) {
        solved->centres = places;
        solved->system = RbfSystem(places, basis_, solved->polynomials, within);
        solved->near = NearCentres(places, reach());
        solved_ = std::move(solved);
        return own;
    }
    const RowMatrix all = handles_.all_shares();
    const RowMatrix values = solved->places->means(all);
    if (options_.tolerance == 0.0 || places.rows() <= few_points || is_compact(options_.function)) {
        solved->centres = places;
        const RbfSystem system(places, basis_, solved->polynomials, within);
        solved->coefficients = system.solve(values);
    } else {
        RbfFit fit =
            fit_incrementally(places, values, basis_, solved->polynomials, options_.tolerance, within);
        solved->centres = std::move(fit.centres);
        solved->coefficients = std::move(fit.coefficients);
    }
    solved->near = NearCentres(solved->centres, reach());
    const int q = solved->polynomials.count(), count = q + static_cast<int>(solved->centres.rows());
    const auto columns = static_cast<int>(values.cols());
    solved->factors.assign(static_cast<std::size_t>((columns + 2) / 3) * count * 3, 0.0);
    for (int k = 0; k < columns; ++k)
        for (int j = 0; j < count; ++j)
            solved->factors[(static_cast<std::size_t>(k / 3) * count + j) * 3 + k % 3] =
                j < q ? solved->coefficients.polynomial(j, k)
                      : solved->coefficients.weights(solved->near.order()[j - q], k);
    // What all handle points get, against what they should get: those held in part share their targets.
    const auto m = static_cast<int>(all.rows());
    std::vector<double> worst(static_cast<std::size_t>((m + 63) / 64), 0.0);
    parallel_chunks(m, 64, [&](int begin, int end) {
        RowMatrix rows;
        const Points block = handles_.points().middleRows(begin, end - begin);
        evaluate(*solved, view(block), rows);
        for (int i = begin; i < end; ++i) {
            const auto target = handles_.weight(i) == 1.0 ? all.row(i) : values.row(solved->places->of[i]);
            double& own = worst[static_cast<std::size_t>(begin / 64)];
            own = std::max(own, (rows.row(i - begin) - target).cwiseAbs().sum());
        }
    });
    solved->error = *std::ranges::max_element(worst);
    within.tick(1.0, "checking the handles");
    solved_ = std::move(solved);
    return own;
}

void Rbf::evaluate(int /*first*/, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    evaluate(*solved_, block, rows);
    outside.assign(static_cast<std::size_t>(block.rows()), 0);
}

void Rbf::evaluate(const Solved& solved, PointsView block, RowMatrix& rows) const
{
    const int n = static_cast<int>(block.rows()), columns = static_cast<int>(handles_.control().rows()),
              q = solved.polynomials.count(), count = q + static_cast<int>(solved.centres.rows());
    const auto phi = widest_kernels<RbfKernels>().values[static_cast<int>(basis_.function)];
    const auto multiply = widest_kernels<ProductOfEight>().multiply;
    rows.resize(n, columns);
    // Sums to start from, and then monomials or values at centres: eight numbers each.
    std::vector<double> values(24 + 8 * static_cast<std::size_t>(count), 0.0);
    std::vector<double> sums(static_cast<std::size_t>((columns + 2) / 3) * 24);
    const auto add = [&](int begin, int end) { // what is in `values`, of these rows of the factors
        for (std::size_t k = 0; 24 * k < sums.size(); ++k) {
            std::copy_n(sums.data() + 24 * k, 24, values.data());
            multiply(values.data(), end - begin, solved.factors.data() + (k * count + begin) * 3,
                     sums.data() + 24 * k);
        }
    };
    const std::vector<int> order = is_compact(basis_.function) ? space_order(block) : std::vector<int>{};
    for (int first = 0; first < n; first += 8) {
        const Eight eight(*this, block, order, first);
        solved.polynomials.evaluate(eight.places.data(), values.data() + 24);
        std::ranges::fill(sums, 0.0);
        add(0, q);
        solved.near.visit(eight.low, eight.high, [&](int begin, int end) {
            phi(solved.near.centres().row(begin).data(), end - begin, basis_.scale, eight.places.data(),
                values.data() + 24);
            add(q + begin, q + end);
        });
        for (int k = 0; k < columns; ++k)
            for (int i = 0; i < eight.count; ++i)
                rows(eight.points[i], k) = sums[24 * static_cast<std::size_t>(k / 3) + 8 * (k % 3) + i];
    }
}

void Rbf::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    if (!handles_.all_single()) {
        LinearSpaceMethod::compute(points, report, progress);
        return;
    }
    progress.tick(0.0, "computing weights");
    prepare(points, progress);
    std::vector<int> order = is_compact(basis_.function) ? space_order(points) : std::vector<int>{};
    finish(report);
    progress.tick(1.0, "computing weights");
    order_ = std::move(order);
}

void Rbf::finish(SpaceReport& report) const
{
    const Solved& solved = *solved_;
    report.error = solved.error;
    if (handles_.all_single())
        report.weight_bytes = solved.system.bytes();
    if (const std::string remark = solved.polynomials.remark(); !remark.empty())
        report.remarks.push_back(remark);
    if (!handles_.all_single() && solved.error > std::max(1e-6, 1.01 * options_.tolerance)) {
        std::array<char, 64> text{};
        std::snprintf(text.data(), text.size(), "%.1e", solved.error);
        report.remarks.push_back(std::string("handle points are met to ") + text.data() +
                                 " of the longest move");
    }
    std::vector<int> near;
    for (int i = 0; i < handles_.point_count(); ++i)
        if (handles_.all_single() && solved.places->sizes[static_cast<std::size_t>(solved.places->of[i])] > 1)
            near.push_back(i);
    if (!near.empty())
        report.remarks.push_back("handle points " + list_some(near) +
                                 " nearly coincide with others: they are met in the mean");
    if (handles_.all_single() && !is_compact(basis_.function) && handles_.point_count() > many_points)
        report.remarks.push_back(std::to_string(handles_.point_count()) +
                                 " handle points: a bind takes as long as their cube; use fewer, or a kernel "
                                 "with a radius");
    if (solved.system.softness() > 0.0)
        report.remarks.emplace_back("handle points are so close together that some are only nearly met");
}

void Rbf::displace(PointsView control, PointsView base, PositionsOut out) const
{
    if (!handles_.all_single()) {
        LinearSpaceMethod::displace(control, base, out);
        return;
    }
    handles_.check(control);
    const Solved& solved = *solved_;
    const auto c = static_cast<int>(solved.centres.rows());
    const RbfCoefficients found = solved.system.solve(solved.places->means(control - handles_.points()));
    std::vector<double> table(6 * static_cast<std::size_t>(c));
    for (int j = 0; j < c; ++j)
        for (int k = 0; k < 3; ++k) {
            table[6 * static_cast<std::size_t>(j) + k] = solved.near.centres()(j, k);
            table[6 * static_cast<std::size_t>(j) + 3 + k] = found.weights(solved.near.order()[j], k);
        }
    std::visit([&](auto* positions) { add_sums(table, found.polynomial, base, positions); }, out);
}

template <class Real>
void Rbf::add_sums(const std::vector<double>& table, const RowMatrix& polynomial, PointsView base,
                   Real* out) const
{
    const PointsView bound = view(points());
    const auto sums_of = widest_kernels<RbfKernels>().sums[static_cast<int>(basis_.function)];
    const auto multiply = widest_kernels<ProductOfEight>().multiply;
    const int q = static_cast<int>(polynomial.rows());
    parallel_chunks(static_cast<int>(bound.rows()), 512, [&](int from, int to) {
        std::array<double, 24> moves{};
        std::array<double, 24 + 8 * Polynomials::most> sums; // of radial functions, and then the monomials
        for (int first = from; first < to; first += 8) {
            const Eight eight(*this, bound, order_, first);
            std::fill_n(sums.data(), 24, 0.0);
            solved_->near.visit(eight.low, eight.high, [&](int begin, int end) {
                sums_of(table.data() + 6 * static_cast<std::size_t>(begin), end - begin, basis_.scale,
                        eight.places.data(), sums.data());
            });
            solved_->polynomials.evaluate(eight.places.data(), sums.data() + 24);
            multiply(sums.data(), q, polynomial.data(), moves.data());
            for (int i = 0; i < eight.count; ++i)
                for (int k = 0; k < 3; ++k)
                    out[3 * static_cast<std::size_t>(eight.points[i]) + k] =
                        static_cast<Real>(base(eight.points[i], k) + moves[8 * k + i]);
        }
    });
}

std::vector<std::string> Rbf::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const Rbf&>(former);
    return changed(options_, other.options_, names_of({{"handles", !(handles_ == other.handles_)}}));
}

void Rbf::swap_weights(SpaceMethod& other)
{
    LinearSpaceMethod::swap_weights(other);
    std::swap(solved_, static_cast<Rbf&>(other).solved_);
    std::swap(order_, static_cast<Rbf&>(other).order_);
}

} // namespace sinew
