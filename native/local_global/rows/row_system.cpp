// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/rows/row_system.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/cell_fits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace sinew {

namespace {

/// Terms of one row cancel in a translation up to this share.
constexpr double balanced = 1e-12;
/// Of the largest entry of M: what a group without weight gets as its pivot.
constexpr double least_moment = 1e-12;

std::vector<bool> all_or(const std::vector<bool>& flags, int count)
{
    return flags.empty() ? std::vector<bool>(count, false) : flags;
}

} // namespace

RowSystem::RowSystem(const RowTable& rows, const Points& rest, const std::vector<bool>& held_points,
                     const std::vector<bool>& held_groups, const RotationCellsOptions& options)
    : options_(options), has_pairs_(rows.has_pairs())
{
    options_.field = options.field && has_pairs_;
    const std::vector<bool> held = all_or(held_groups, rows.group_count());
    factorize(rows, held_points);
    number_groups(rows, held);
    if (options_.field)
        factorize_field(rows, rest, held);
    if (has_pairs_ || !options.four_points || !sum_up(rows))
        lay_out(rows);
    collect_parts();
    view_ = {.rows = group_rows_.data(),
             .terms = row_terms_.data(),
             .term_points = term_points_.data(),
             .coefficients = coefficients_.data(),
             .weights = weights_.data(),
             .vectors = nullptr,
             .row_groups = row_groups_.data(),
             .first_turns = first_turns_.data(),
             .turns = turns_.data(),
             .parts = parts_.data(),
             .part_forces = part_forces_.data(),
             .part_shares = part_shares_.data(),
             .corners = corners_.data(),
             .matrices = matrices_.data(),
             .base = nullptr,
             .points = nullptr};
    set_vectors(sinew::view(rest), rest_);
}

void RowSystem::factorize(const RowTable& rows, const std::vector<bool>& held)
{
    const int points = rows.point_count();
    std::vector<int> place(points, -1), free_points;
    for (int i = 0; i < points; ++i)
        if (!held[i]) {
            place[i] = free_++;
            free_points.push_back(i);
        }
    std::vector<Eigen::Triplet<double>> entries;
    for (const RowTable::Row& row : rows.rows())
        for (const auto& a : rows.terms(row))
            for (const auto& b : rows.terms(row))
                if (place[a.point] >= 0 && place[b.point] >= 0)
                    entries.emplace_back(place[a.point], place[b.point],
                                         row.weight * a.coefficient * b.coefficient);
    for (const RowTable::Pull& pull : rows.pulls())
        if (place[pull.point] >= 0)
            entries.emplace_back(place[pull.point], place[pull.point], pull.stiffness);
    SparseMatrix A(free_, free_);
    A.setFromTriplets(entries.begin(), entries.end());
    const std::vector<int> elimination = fill_reducing_order(A);
    try {
        position_factor_.factorize(A, elimination);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty())
            throw;
        throw FactorizationFailed(failure.what(), Error::Element::vertex,
                                  {free_points[failure.elements().front()]});
    }
    places_.assign(points, -1);
    std::vector<int> names(free_);
    for (int f = 0; f < free_; ++f) {
        const int unknown = position_factor_.order()[f];
        names[unknown] = f;
        order_.push_back(free_points[unknown]);
        places_[free_points[unknown]] = f;
    }
    position_factor_.rename(names);
    for (int i = 0; i < points; ++i)
        if (held[i]) {
            places_[i] = static_cast<int>(order_.size());
            order_.push_back(i);
        }
    for (const RowTable::Pull& pull : rows.pulls())
        if (!held[pull.point])
            pulls_.push_back({places_[pull.point], pull.stiffness});
}

void RowSystem::number_groups(const RowTable& rows, const std::vector<bool>& held)
{
    const int groups = rows.group_count(), none = std::numeric_limits<int>::max();
    std::vector<int> nearest(groups, none); // the first point that its rows touch
    for (const RowTable::Row& row : rows.rows())
        for (const auto& term : rows.terms(row))
            for (const int g : row.group)
                if (g >= 0)
                    nearest[g] = std::min(nearest[g], places_[term.point]);
    const auto kind = [&](int g) {
        if (has_pairs_)
            return held[g] ? Chunk::steady : Chunk::moving;
        if (nearest[g] >= free_)
            return Chunk::fixed;
        return held[g] ? Chunk::steady : Chunk::moving;
    };
    group_order_.resize(groups);
    std::iota(group_order_.begin(), group_order_.end(), 0);
    std::ranges::sort(group_order_, {}, [&](int g) { return std::tuple(kind(g), nearest[g], g); });
    group_places_.resize(groups);
    for (int g = 0; g < groups; ++g) {
        group_places_[group_order_[g]] = g;
        moving_ += kind(group_order_[g]) == Chunk::moving;
        active_ += kind(group_order_[g]) != Chunk::fixed;
    }
    for (int begin = 0; begin < groups;) {
        const int bound = begin < moving_ ? moving_ : begin < active_ ? active_ : groups;
        const int end = std::min(begin + graph_chunk, bound);
        chunks_.push_back({begin, end, kind(group_order_[begin])});
        begin = end;
    }
}

void RowSystem::factorize_field(const RowTable& rows, const Points& rest, const std::vector<bool>& held)
{
    std::vector<Eigen::Triplet<double>> entries;
    double largest = 1e-280;
    for (const RowTable::Row& row : rows.rows()) {
        Vector3 vectors[2]{row.vector[0], row.vector[1]};
        if (row.group[1] < 0)
            for (const auto& term : rows.terms(row))
                vectors[0] += term.coefficient * rest.row(term.point).transpose();
        for (int s = 0; s < 2; ++s)
            for (int t = 0; t < 2; ++t) {
                if (row.group[s] < 0 || row.group[t] < 0 || held[row.group[s]] || held[row.group[t]])
                    continue;
                const double entry = 2.0 / 3.0 * row.weight * vectors[s].dot(vectors[t]);
                entries.emplace_back(group_places_[row.group[s]], group_places_[row.group[t]], entry);
                largest = std::max(largest, entry);
            }
    }
    for (int g = 0; g < moving_; ++g) // a group without extent needs a positive pivot, too
        entries.emplace_back(g, g, least_moment * largest);
    SparseMatrix M(moving_, moving_);
    M.setFromTriplets(entries.begin(), entries.end());
    rotation_factor_.factorize(M);
}

void RowSystem::lay_out(const RowTable& rows)
{
    const std::vector<RowTable::Row>& given = rows.rows();
    std::vector<int> row_order(given.size());
    std::iota(row_order.begin(), row_order.end(), 0);
    std::ranges::stable_sort(row_order, {}, [&](int k) { return group_places_[given[k].group[0]]; });
    group_rows_.assign(group_count() + 1, 0);
    for (const int k : row_order) {
        const RowTable::Row& row = given[k];
        ++group_rows_[group_places_[row.group[0]] + 1];
        for (const auto& term : rows.terms(row)) {
            term_points_.push_back(places_[term.point]);
            coefficients_.push_back(term.coefficient);
        }
        row_terms_.push_back(static_cast<int>(term_points_.size()));
        weights_.push_back(row.weight);
        if (!has_pairs_)
            continue;
        for (int side = 0; side < 2; ++side) {
            row_groups_.push_back(row.group[side] >= 0 ? group_places_[row.group[side]] : -1);
            for (int axis = 0; axis < 3; ++axis)
                fixed_vectors_.push_back(row.vector[side][axis]);
        }
    }
    std::partial_sum(group_rows_.begin(), group_rows_.end(), group_rows_.begin());
    if (!has_pairs_)
        return;
    first_turns_.assign(group_count() + 1, 0);
    for (const int g : row_groups_)
        if (g >= 0)
            ++first_turns_[g + 1];
    std::partial_sum(first_turns_.begin(), first_turns_.end(), first_turns_.begin());
    turns_.resize(first_turns_.back());
    std::vector<int> next(first_turns_.begin(), first_turns_.end() - 1);
    for (std::size_t t = 0; t < row_groups_.size(); ++t)
        if (row_groups_[t] >= 0)
            turns_[next[row_groups_[t]]++] = static_cast<int>(t);
}

/// Sums up the rows of each group as a quadratic form of four points.
/// \return false, with nothing done, where a group has more points or a row does not cancel in a translation.
bool RowSystem::sum_up(const RowTable& rows)
{
    std::vector<int> corners(4 * static_cast<std::size_t>(group_count()), -1);
    std::vector<double> matrices(6 * static_cast<std::size_t>(group_count()), 0.0);
    const auto corner = [&](int g, int point) {
        for (int k = 0; k < 4; ++k) {
            int& own = corners[4 * static_cast<std::size_t>(g) + k];
            if (own < 0)
                own = point;
            if (own == point)
                return k;
        }
        return -1;
    };
    for (const RowTable::Row& row : rows.rows()) {
        const int g = group_places_[row.group[0]];
        double c[4] = {0, 0, 0, 0}, sum = 0.0, size = 0.0;
        for (const auto& term : rows.terms(row)) {
            const int k = corner(g, places_[term.point]);
            if (k < 0)
                return false;
            c[k] += term.coefficient;
            sum += term.coefficient;
            size += std::abs(term.coefficient);
        }
        if (std::abs(sum) > balanced * size)
            return false;
        double* m = matrices.data() + 6 * static_cast<std::size_t>(g);
        for (int a = 1; a < 4; ++a)
            for (int b = a; b < 4; ++b)
                *m++ += row.weight * c[a] * c[b];
    }
    for (int g = 0; g < group_count(); ++g) // corners that no row needs have no weight
        for (int k = 0; k < 4; ++k)
            if (int& own = corners[4 * static_cast<std::size_t>(g) + k]; own < 0)
                own = k > 0 ? corners[4 * static_cast<std::size_t>(g)] : 0;
    corners_ = std::move(corners);
    matrices_ = std::move(matrices);
    return true;
}

/// Lists for each free point the forces that act on it.
void RowSystem::collect_parts()
{
    std::vector<int> count(free_ + 1, 0);
    const auto each = [&](auto&& visit) { // (point, force, share)
        if (has_four_points()) {
            for (int a = 0; a < 4 * active_; ++a)
                visit(corners_[a], a, 1.0);
            return;
        }
        for (int k = 0; k < group_rows_[active_]; ++k)
            for (int a = row_terms_[k]; a < row_terms_[k + 1]; ++a)
                visit(term_points_[a], k, coefficients_[a]);
    };
    each([&](int point, int, double) {
        if (point < free_)
            ++count[point + 1];
    });
    std::partial_sum(count.begin(), count.end(), count.begin());
    parts_ = count;
    part_forces_.resize(count.back());
    part_shares_.resize(count.back());
    each([&](int point, int force, double share) {
        if (point >= free_)
            return;
        part_forces_[count[point]] = force;
        part_shares_[count[point]++] = share;
    });
}

Points RowSystem::free_rows(const PointsView& points) const
{
    Points result(free_, 3);
    parallel_for(free_, [&](int i) { result.row(i) = points.row(order_[i]); });
    return result;
}

void RowSystem::set_vectors(const PointsView& base, RotationVectors& out) const
{
    out.base.resize(3 * order_.size() + 1);
    parallel_for(point_count(), [&](int i) {
        for (int axis = 0; axis < 3; ++axis)
            out.base[3 * static_cast<std::size_t>(i) + axis] = base(order_[i], axis);
    });
    if (has_four_points())
        return;
    if (out.numbers.empty()) {
        out.numbers = fixed_vectors_;
        out.numbers.resize(3 * static_cast<std::size_t>(row_count()) * (has_pairs_ ? 2 : 1) + 1);
    }
    parallel_for(row_count(), [&](int k) {
        if (has_pairs_ && row_groups_[2 * static_cast<std::size_t>(k) + 1] >= 0)
            return;
        Vector3 u = Vector3::Zero();
        for (int a = row_terms_[k]; a < row_terms_[k + 1]; ++a)
            u += coefficients_[a] *
                 Eigen::Map<const Vector3>(out.base.data() + 3 * static_cast<std::size_t>(term_points_[a]));
        Eigen::Map<Vector3>(out.numbers.data() + 3 * static_cast<std::size_t>(has_pairs_ ? 2 * k : k)) = u;
    });
}

double RowSystem::scale(const RotationVectors& vectors) const
{
    const auto at = [](const std::vector<double>& numbers, int i) {
        return Eigen::Map<const Vector3>(numbers.data() + 3 * static_cast<std::size_t>(i));
    };
    if (!has_four_points())
        return 0.5 * parallel_sum(row_count(), [&](int k) {
                   if (has_pairs_ && row_groups_[2 * static_cast<std::size_t>(k) + 1] >= 0)
                       return 0.0;
                   return weights_[k] * at(vectors.numbers, has_pairs_ ? 2 * k : k).squaredNorm();
               });
    return 0.5 * parallel_sum(group_count(), [&](int g) {
               const int* const corner = corners_.data() + 4 * static_cast<std::size_t>(g);
               const double* m = matrices_.data() + 6 * static_cast<std::size_t>(g);
               Vector3 edge[3];
               for (int k = 0; k < 3; ++k)
                   edge[k] = at(vectors.base, corner[k + 1]) - at(vectors.base, corner[0]);
               double sum = 0.0;
               for (int a = 0; a < 3; ++a)
                   for (int b = a; b < 3; ++b)
                       sum += (a == b ? 1.0 : 2.0) * *m++ * edge[a].dot(edge[b]);
               return sum;
           });
}

} // namespace sinew
