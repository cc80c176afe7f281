// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/part.h"
#include "native/mesh/edge_distances.h"
#include "native/mesh/trees/triangle_tree.h"

#include <memory>
#include <span>
#include <vector>

namespace sinew {

/// Barycentric coordinates of a point of a triangle; those of the first corner if it is flat.
Vector3 barycentric(const Corners& triangle, const Vector3& point);

/// A part at rest on which others ride. Triangles of less than 1e-10 of the largest area are left out of its
/// surface.
class HostSurface
{
public:
    /// \param part  has some area, and must live as long as the host.
    explicit HostSurface(const Part& part);

    const Part& part() const { return *part_; }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const std::vector<double>& areas() const { return areas_; }
    const std::vector<Vector3>& centres() const { return centres_; }
    /// sqrt(2 mean area of the triangles): about how long an edge is.
    double spacing() const { return spacing_; }
    /// The triangles that have this vertex.
    std::span<const int> around(int vertex) const
    {
        return {around_.data() + offsets_[vertex], around_.data() + offsets_[vertex + 1]};
    }

    /// Of triangles(). Call prepare_tree() first.
    const TriangleTree& tree() const { return *tree_; }
    void prepare_tree()
    {
        if (!tree_)
            tree_ = std::make_unique<TriangleTree>(part_->points, triangles_);
    }
    /// Finds out whether the surface is its own mirror image, to 1e-3 of its size, in a plane across an axis:
    /// through the origin or the middle of its box. Call prepare_tree() first.
    void find_mirror_plane();
    /// Whether the middles of a part and of its box are on the mirror plane, to 1e-2 of its size. Call
    /// find_mirror_plane() first.
    bool lies_on_mirror_plane(const Part& part) const;
    Vector3 mirror_image(Vector3 point) const
    {
        point[mirror_axis_] = 2.0 * mirror_place_ - point[mirror_axis_];
        return point;
    }

    /// The vertices nearest to the images of three vertices, turned round. Of a triangle that has none of its
    /// own, the one where its middle would be.
    Triangle mirror_image(const Triangle& corners) const;
    bool is_near_mirror_plane(const Vector3& point) const
    {
        return (mirror_image(point) - point).norm() <= 2.0 * spacing_;
    }

    /// Call prepare_edges() first.
    const EdgeDistances& edges() const { return *edges_; }
    void prepare_edges()
    {
        if (!edges_)
            edges_ = std::make_unique<EdgeDistances>(part_->points, part_->ways());
    }

private:
    const Part* part_;
    std::vector<Triangle> triangles_;
    std::vector<double> areas_;
    std::vector<Vector3> centres_;
    double spacing_ = 0.0;
    std::vector<int> offsets_, around_;
    std::unique_ptr<TriangleTree> tree_;
    int mirror_axis_ = -1; ///< -1 for none
    double mirror_place_ = 0.0;
    std::unique_ptr<EdgeDistances> edges_;
};

} // namespace sinew
