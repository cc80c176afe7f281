// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"
#include "native/core/types.h"

#include <utility>
#include <vector>

namespace sinew {

/// Refuses weights of handle points; none stand for 1 everywhere.
/// \throw InvalidConstraint  there is another number of weights than of points.
/// \throw InvalidOption      a weight is not in (0, 1].
void require_weights(const std::vector<double>& weights, Eigen::Index points);

/// Points that handles take along, at rest.
///
/// A handle of one point moves it anywhere. A handle of more points moves them by one affine map, which is
/// posed by four control points: the mean o of its points, and o + s e_k along the three axes, where s is the
/// size of all handles. So the control of k handles is (k to 4 k, 3) points, whatever moves them, and a
/// handle of thousands of points costs a frame no more than one of two. Methods that let handles pull,
/// instead of interpolating them, take the points and fit a motion to those of each handle (HandleControl).
class HandlePoints
{
public:
    /// \param points  (c, 3) handle after handle.
    /// \param counts  how many points each handle has, all >= 1; empty if each point is a handle.
    /// \param weights (c) in (0, 1], how strongly each point is held; empty where all are 1. Methods that
    ///                interpolate handles hold a point fully, if it is alone; where several handles hold one
    ///                place, it goes to the mean of their targets by these weights. Handles that hold it
    ///                fully overrule those that hold it in part.
    /// \throw InvalidConstraint  a point is not finite, there is none, the counts do not sum to c, or there
    ///   is another number of weights than of points.
    /// \throw InvalidOption      a weight is not in (0, 1].
    explicit HandlePoints(PointsView points, std::vector<int> counts = {}, std::vector<double> weights = {});

    int handle_count() const { return static_cast<int>(begins_.size()) - 1; }
    int point_count() const { return static_cast<int>(points_.rows()); }
    const Points& points() const { return points_; }
    /// The points of a handle are [begin(h), begin(h + 1)).
    int begin(int handle) const { return begins_[handle]; }
    int count(int handle) const { return begins_[handle + 1] - begins_[handle]; }
    bool is_single(int handle) const { return count(handle) == 1; }
    bool all_single() const { return handle_count() == point_count(); }
    int handle_of(int point) const { return handle_of_[point]; }
    double weight(int point) const { return weights_.empty() ? 1.0 : weights_[point]; }
    bool all_full() const { return weights_.empty(); }
    /// Pairs of points at one place that two handles hold fully.
    const std::vector<std::pair<int, int>>& twins() const { return twins_; }

    /// The control at rest. Rows [column(h), column(h + 1)) belong to handle h.
    const Points& control() const { return control_; }
    int column(int handle) const { return columns_[handle]; }
    /// (3) the lowest corner of the box around the points, and the diameter of the smallest ball around them;
    /// 1 if all are one point.
    const Vector3& corner() const { return corner_; }
    double size() const { return size_; }

    /// The control points that a point depends on, and how: it is the sum of shares times control points, and
    /// the shares sum to 1. `shares` has four entries, of which a handle of one point uses the first.
    void shares(int point, double* shares) const;
    /// (c, columns) the shares of all points: the right-hand sides of a linear method.
    RowMatrix all_shares() const;

    /// The control, and the points, (r, 3) and (c, 3), where each handle moves them by its pose.
    /// \throw InvalidConstraint  there is another number of poses than of handles.
    Points posed_control(const Poses& poses) const { return moved(control_, columns_, poses); }
    Points posed_points(const Poses& poses) const { return moved(points_, begins_, poses); }

    /// How a posed control moves a handle: x -> A x + t. A of a handle of one point is the identity.
    Pose map(PointsView posed, int handle) const;

    /// \throw InvalidConstraint  a posed control of another size; one that is not finite; or twins() that go
    ///   apart, which names their handles.
    void check(PointsView posed) const;

    bool operator==(const HandlePoints& other) const
    {
        return begins_ == other.begins_ && weights_ == other.weights_ && points_ == other.points_;
    }

private:
    Vector3 posed_point(PointsView posed, int point) const;
    /// Rows [begins[h], begins[h + 1]) are moved by the pose of handle h.
    Points moved(const Points& rest, const std::vector<int>& begins, const Poses& poses) const;

    Points points_, control_;
    std::vector<int> begins_, columns_, handle_of_;
    std::vector<double> weights_;
    std::vector<std::pair<int, int>> twins_;
    Vector3 corner_ = Vector3::Zero();
    double size_ = 1.0;
};

} // namespace sinew
