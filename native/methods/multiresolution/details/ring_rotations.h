// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/parallel.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <algorithm>
#include <span>
#include <vector>

namespace sinew {

/// The map of a triangle that takes its two edges and its normal to those of another shape, times its area.
/// All is zero where the area is below 1e-7 of the longest edge squared: it says nothing about a map then.
struct FaceMap
{
    Matrix3 weighted; ///< area T, with T = [e1' e2' n'] [e1 e2 n]^-1
    double area, other_area; ///< of the triangle in both shapes
    Vector3 normal, other_normal; ///< unit
};
FaceMap face_map(const PointsView& before, const PointsView& after, const Triangle& triangle);

/// What the map of a triangle has from the shape before: area T = e1' first^T + e2' second^T + n' normal^T.
struct FaceDual
{
    Vector3 first, second, normal; ///< all zero where the area says nothing
};
FaceDual face_dual(const PointsView& before, const Triangle& triangle);

/// How each vertex of a surface turned from one shape to another: the rotation that is closest to the sum of
/// the maps of its triangles, weighted by their areas.
///
/// No edge is singled out, and equal shapes give the identity to rounding. Where the triangles of a vertex
/// have no area, those of its neighbours count, and where these have none, it gets the identity.
///
///   call         cost
///   constructor  O(n)
///   fit()        O(n), one rotation fit per vertex; safe from several threads
class RingRotations
{
public:
    RingRotations() = default;
    explicit RingRotations(const SurfaceMesh& mesh);

    /// Calls use(vertex, rotation, sum) for the vertices for which wanted(vertex) is true, both from several
    /// threads; the sum is that of the maps of its triangles times their areas.
    /// \param before  (n, 3), or what duals() returned for it.
    /// \param after   (n, 3)
    /// \param maps    a workspace that is kept from call to call.
    template <class Before, class Wanted, class Use>
    void fit(const Before& before, const PointsView& after, std::vector<Matrix3>& maps, const Wanted& wanted,
             const Use& use) const
    {
        map_all(before, after, maps);
        parallel_chunks(static_cast<int>(after.rows()), 2048, [&](int begin, int end) {
            int vertices[4], count = 0;
            Matrix3 sums[4], turns[4];
            std::fill_n(sums, 4, Matrix3::Identity());
            const auto finish = [&] {
                fit_four(count, sums, turns);
                for (int k = 0; k < count; ++k)
                    use(vertices[k], turns[k], sums[k]);
                count = 0;
            };
            for (int v = begin; v < end; ++v)
                if (wanted(v)) {
                    vertices[count] = v;
                    sums[count++] = sum_of(maps, v);
                    if (count == 4)
                        finish();
                }
            finish();
        });
    }

    /// One per triangle, for a shape before that stays.
    std::vector<FaceDual> duals(const PointsView& before) const;

    /// The rotation of one vertex alone.
    Matrix3 at(const PointsView& before, const PointsView& after, int vertex) const;

    const std::vector<Triangle>& triangles() const { return triangles_; }
    /// The triangles at a vertex.
    std::span<const int> around(int vertex) const
    {
        return {around_.data() + offsets_[vertex], around_.data() + offsets_[vertex + 1]};
    }

private:
    /// (triangles) their maps times their areas.
    void map_all(const PointsView& before, const PointsView& after, std::vector<Matrix3>& maps) const;
    void map_all(const std::vector<FaceDual>& before, const PointsView& after,
                 std::vector<Matrix3>& maps) const;
    /// The sum of those that decide about a vertex.
    Matrix3 sum_of(const std::vector<Matrix3>& maps, int vertex) const;
    /// The rotations that are closest to up to four matrices.
    static void fit_four(int count, const Matrix3* matrices, Matrix3* rotations);
    /// The sum of map(triangle) over the triangles that decide about a vertex.
    template <class Map>
    Matrix3 sum_around(int vertex, const Map& map) const;

    std::vector<Triangle> triangles_;
    std::vector<int> offsets_, around_;
};

} // namespace sinew
