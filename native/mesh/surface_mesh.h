// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <array>
#include <span>
#include <vector>

namespace sinew {

using Triangle = std::array<int, 3>;

/// A polygon surface with faces of any size. It may have any number of parts, boundaries, non-manifold edges,
/// duplicate faces, faces without area, and loose vertices. It never changes after construction.
///
/// The constructor triangulates faces of more than three corners, so that every operator works on the same
/// surface: quads along the better diagonal, larger faces by ear clipping in the plane of their area vector.
class SurfaceMesh
{
public:
    /// \param points   (n, 3) rest positions, n >= 1, finite, no coordinate above 1e60; the longest side of
    /// the box
    ///   around them is 0 or at least 1e-60. So areas, volumes and their inverses are normal numbers.
    /// \param counts   (m) number of corners of each face, each >= 3.
    /// \param corners  (sum of counts) vertex indices, face after face.
    /// \throw InvalidMesh  there is no vertex, a point is not finite or out of range, a face has fewer than
    /// three corners, an
    ///   index is out of range, or the counts do not add up.
    SurfaceMesh(Points points, std::vector<int> counts, std::vector<int> corners);

    const Points& points() const { return points_; }
    Vector3 point(int vertex) const { return points_.row(vertex).transpose(); }
    int vertex_count() const { return static_cast<int>(points_.rows()); }

    int face_count() const { return static_cast<int>(offsets_.size()) - 1; }
    std::span<const int> face(int face) const
    {
        return {corners_.data() + offsets_[face], corners_.data() + offsets_[face + 1]};
    }

    const std::vector<Triangle>& triangles() const { return triangles_; }
    /// The face that triangle t was cut from.
    const std::vector<int>& triangle_faces() const { return triangle_faces_; }

    /// The same faces over other points. Quads and larger faces are cut anew.
    /// \throw InvalidMesh  as the constructor.
    SurfaceMesh with_points(Points points) const;

    bool operator==(const SurfaceMesh& other) const;
    /// Whether the constructor was given the same points, counts and corners.
    bool is_made_of(const PointsView& points, std::span<const int> counts,
                    std::span<const int> corners) const;

    /// The edges (a < b) of the faces, each once, without the cuts of the triangulation.
    std::vector<std::array<int, 2>> edges() const;

private:
    Points points_;
    std::vector<int> offsets_;
    std::vector<int> corners_;
    std::vector<Triangle> triangles_;
    std::vector<int> triangle_faces_;
};

} // namespace sinew
