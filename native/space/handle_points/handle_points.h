// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/errors.h"
#include "native/core/types.h"

#include <utility>
#include <vector>

namespace sinew {

/// Points that handles take along, at rest.
///
/// A handle of one point moves it anywhere. A handle of more points moves them by one affine map, which is
/// posed by four control points: the mean o of its points, and o + s e_k along the three axes, where s is the
/// size of all handles. So the control of k handles is (k to 4 k, 3) points, whatever moves them, and a
/// handle of thousands of points costs a frame no more than one of two.
class HandlePoints
{
public:
    /// \param points  (c, 3) handle after handle.
    /// \param counts  how many points each handle has, all >= 1; empty if each point is a handle.
    /// \throw InvalidConstraint  a point is not finite, there is none, or the counts do not sum to c.
    explicit HandlePoints(PointsView points, std::vector<int> counts = {});

    int handle_count() const { return static_cast<int>(begins_.size()) - 1; }
    int point_count() const { return static_cast<int>(points_.rows()); }
    const Points& points() const { return points_; }
    /// The points of a handle are [begin(h), begin(h + 1)).
    int begin(int handle) const { return begins_[handle]; }
    bool is_single(int handle) const { return begins_[handle + 1] - begins_[handle] == 1; }
    bool all_single() const { return handle_count() == point_count(); }
    int handle_of(int point) const { return handle_of_[point]; }

    /// The control at rest. Rows [column(h), column(h + 1)) belong to handle h.
    const Points& control() const { return control_; }
    int column(int handle) const { return columns_[handle]; }
    /// (3) the lowest corner of the box around the points, and its longest side; 1 if all are one point.
    const Vector3& corner() const { return corner_; }
    double size() const { return size_; }

    /// The control points that a point depends on, and how: it is the sum of shares times control points, and
    /// the shares sum to 1. `shares` has four entries, of which a handle of one point uses the first.
    void shares(int point, double* shares) const;
    /// (c, columns) the shares of all points: the right-hand sides of a linear method.
    RowMatrix all_shares() const;

    /// How a posed control moves a handle: x -> A x + t. A of a handle of one point is the identity.
    Pose map(PointsView posed, int handle) const;

    /// \throw InvalidConstraint  a posed control of another size; one that is not finite; or points of
    /// several
    ///   handles at one place that go apart, which names these handles.
    void check(PointsView posed) const;

    bool operator==(const HandlePoints& other) const
    {
        return begins_ == other.begins_ && points_ == other.points_;
    }

private:
    Vector3 posed_point(PointsView posed, int point) const;

    Points points_, control_;
    std::vector<int> begins_, columns_, handle_of_;
    std::vector<std::pair<int, int>> twins_; ///< pairs of points of different handles at the same place
    Vector3 corner_ = Vector3::Zero();
    double size_ = 1.0;
};

} // namespace sinew
