// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/handle_points/handle_points.h"

#include "native/core/finite.h"
#include "native/mesh/frames/enclosing_ball.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

/// Targets of one place may differ by this share of the size: single precision of what poses them.
constexpr double same_target = 1e-6;

} // namespace

void require_weights(const std::vector<double>& weights, Eigen::Index points)
{
    if (!weights.empty() && static_cast<Eigen::Index>(weights.size()) != points)
        throw InvalidConstraint("weights: " + std::to_string(weights.size()) + " given for " +
                                std::to_string(points) + " points");
    for (const double weight : weights)
        if (!(weight > 0.0 && weight <= 1.0))
            throw InvalidOption("weights: " + shortest(weight) + " is not in (0, 1]");
}

HandlePoints::HandlePoints(PointsView points, std::vector<int> counts, std::vector<double> weights)
    : points_(points), weights_(std::move(weights))
{
    if (points.rows() == 0)
        throw InvalidConstraint("there is no handle point");
    if (counts.empty())
        counts.assign(static_cast<std::size_t>(points.rows()), 1);
    std::vector<int> bad;
    for (int i = 0; i < points.rows(); ++i)
        if (!points.row(i).allFinite())
            bad.push_back(i);
    std::vector<int> empty;
    for (int h = 0; h < static_cast<int>(counts.size()); ++h)
        if (counts[h] < 1)
            empty.push_back(h);
    if (!empty.empty())
        throw InvalidConstraint("handles " + list_some(empty) + " hold no points", Error::Element::handle,
                                empty);
    begins_.push_back(0);
    for (int h = 0; h < static_cast<int>(counts.size()); ++h) {
        begins_.push_back(begins_.back() + counts[h]);
        handle_of_.insert(handle_of_.end(), static_cast<std::size_t>(counts[h]), h);
    }
    if (begins_.back() != points.rows())
        throw InvalidConstraint("counts: the handles have " + std::to_string(begins_.back()) +
                                " points together, and " + std::to_string(points.rows()) + " are given");
    require_weights(weights_, points.rows());
    if (!bad.empty()) {
        std::vector<int> handles;
        for (int i : bad)
            handles.push_back(handle_of_[i]);
        handles.erase(std::unique(handles.begin(), handles.end()), handles.end());
        throw InvalidConstraint("handle points " + list_some(bad) + " are not finite (handle " +
                                    std::to_string(handles.front()) + ")",
                                Error::Element::handle, handles);
    }
    corner_ = points.colwise().minCoeff().transpose();
    const double longest = (points.colwise().maxCoeff().transpose() - corner_).maxCoeff();
    if (!std::isfinite(longest))
        throw InvalidConstraint("the handle points lie too far apart");
    size_ = longest > 0.0 ? 2.0 * longest * enclosing_ball(points / longest).radius : 1.0;
    columns_.push_back(0);
    for (int h = 0; h < handle_count(); ++h)
        columns_.push_back(columns_.back() + (is_single(h) ? 1 : 4));
    control_.resize(columns_.back(), 3);
    for (int h = 0; h < handle_count(); ++h) {
        const int first = columns_[h];
        if (is_single(h)) {
            control_.row(first) = points_.row(begins_[h]);
            continue;
        }
        const auto own = points_.middleRows(begins_[h], begins_[h + 1] - begins_[h]);
        const Eigen::RowVector3d mean = own.row(0) + (own.rowwise() - own.row(0)).colwise().mean();
        control_.middleRows<4>(first).rowwise() = mean;
        control_.middleRows<3>(first + 1).diagonal().array() += size_;
    }
    std::vector<int> order(static_cast<std::size_t>(point_count()));
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](int i) { return std::make_tuple(points_(i, 0), points_(i, 1), points_(i, 2)); };
    std::ranges::sort(order, {}, [&](int i) { return std::make_pair(place(i), i); });
    for (std::size_t k = 1; k < order.size(); ++k)
        if (const int a = order[k - 1], b = order[k];
            handle_of_[a] != handle_of_[b] && place(a) == place(b) && weight(a) == 1.0 && weight(b) == 1.0)
            twins_.emplace_back(a, b);
}

void HandlePoints::shares(int point, double* shares) const
{
    const int handle = handle_of_[point];
    if (is_single(handle)) {
        shares[0] = 1.0;
        return;
    }
    const Eigen::RowVector3d u = (points_.row(point) - control_.row(columns_[handle])) / size_;
    shares[0] = 1.0 - u.sum();
    for (int k = 0; k < 3; ++k)
        shares[k + 1] = u[k];
}

RowMatrix HandlePoints::all_shares() const
{
    RowMatrix all = RowMatrix::Zero(point_count(), control_.rows());
    for (int i = 0; i < point_count(); ++i)
        shares(i, all.row(i).data() + columns_[handle_of_[i]]);
    return all;
}

Points HandlePoints::moved(const Points& rest, const std::vector<int>& begins, const Poses& poses) const
{
    if (static_cast<int>(poses.size()) != handle_count())
        throw InvalidConstraint("poses: " + std::to_string(poses.size()) + " given for " +
                                std::to_string(handle_count()) + " handles");
    Points posed(rest.rows(), 3);
    for (int h = 0; h < handle_count(); ++h)
        for (int i = begins[h]; i < begins[h + 1]; ++i)
            posed.row(i) = apply(poses[h], rest.row(i).transpose()).transpose();
    return posed;
}

Pose HandlePoints::map(PointsView posed, int handle) const
{
    const int first = columns_[handle];
    Pose pose;
    pose.leftCols<3>().setIdentity();
    if (!is_single(handle))
        for (int k = 0; k < 3; ++k) {
            // The moves are divided, so that the control at rest gives the identity to the last bit.
            const Eigen::RowVector3d tip = posed.row(first + 1 + k) - control_.row(first + 1 + k),
                                     stem = posed.row(first) - control_.row(first);
            pose.col(k) += (tip - stem).transpose() / size_;
        }
    const Vector3 stem = control_.row(first).transpose();
    pose.col(3) = (posed.row(first) - control_.row(first)).transpose() + stem - pose.leftCols<3>() * stem;
    return pose;
}

Vector3 HandlePoints::posed_point(PointsView posed, int point) const
{
    double of[4];
    shares(point, of);
    const int handle = handle_of_[point], first = columns_[handle];
    Vector3 place = Vector3::Zero();
    for (int k = 0; k < columns_[handle + 1] - first; ++k)
        place += of[k] * posed.row(first + k).transpose();
    return place;
}

void HandlePoints::check(PointsView posed) const
{
    if (posed.rows() != control_.rows())
        throw InvalidConstraint("the posed control has " + std::to_string(posed.rows()) +
                                " points, the one at rest has " + std::to_string(control_.rows()));
    if (!all_finite(posed)) {
        std::vector<int> bad;
        for (int h = 0; h < handle_count(); ++h)
            if (!posed.middleRows(columns_[h], columns_[h + 1] - columns_[h]).allFinite())
                bad.push_back(h);
        throw InvalidConstraint("the pose of handle " + std::to_string(bad.empty() ? 0 : bad.front()) +
                                    " is not finite",
                                Error::Element::handle, bad);
    }
    for (const auto& [one, other] : twins_) {
        const double apart = (posed_point(posed, one) - posed_point(posed, other)).norm();
        const double scale = std::max(size_, posed.cwiseAbs().maxCoeff());
        if (apart > same_target * scale) {
            const int a = handle_of_[one], b = handle_of_[other];
            throw InvalidConstraint("handle " + std::to_string(a) + " and handle " + std::to_string(b) +
                                        " hold the same place and move it to different ones",
                                    Error::Element::handle, {std::min(a, b), std::max(a, b)});
        }
    }
}

} // namespace sinew
