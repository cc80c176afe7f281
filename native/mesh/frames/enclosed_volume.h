// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <optional>
#include <vector>

namespace sinew {

/// The volume that triangles enclose, as a function of their points. Each connected border is closed by a fan
/// around the mean of its vertices, so that the volume does not depend on the origin.
class EnclosedVolume
{
public:
    EnclosedVolume() = default;
    /// \param count  number of points
    EnclosedVolume(std::vector<Triangle> triangles, int count);

    bool is_open() const { return !fans_.empty(); }
    /// The area of the fans, as a share of that of the triangles.
    double share_of_fans(const PointsView& points) const;

    double of(const PointsView& points) const;
    /// \param[out] gradient  (n, 3)
    /// \return the volume.
    double gradient(const PointsView& points, Points& gradient) const;
    /// The factors of 1, s, s^2 and s^3 in the volume of points + s * moves.
    std::array<double, 4> along(const PointsView& points, const PointsView& moves) const;
    /// The s near 0 for which the volume of points + s * moves is `wanted`; none where the volume does not
    /// change enough on the way.
    std::optional<double> step(const PointsView& points, const PointsView& moves, double wanted) const;

private:
    /// A vertex of a triangle, or the middle of a border.
    Vector3 corner(const PointsView& points, const Points& middles, int index) const
    {
        if (index < count_)
            return points.row(index).transpose();
        return middles.row(index - count_).transpose();
    }
    Points middles(const PointsView& points) const;

    int count_ = 0;
    std::vector<Triangle> triangles_, fans_; ///< a corner of a fan from count_ on is the middle of a border
    std::vector<std::vector<int>> borders_;  ///< the vertices of each
};

} // namespace sinew
