// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/ring_rotations.h"

#include <memory>
#include <vector>

namespace sinew {

/// Details as heights above the base, along its interpolated normals.
///
/// L. Kobbelt, J. Vorsatz, H.-P. Seidel. "Multiresolution Hierarchies on Unstructured Triangle Meshes."
/// Computational Geometry 14, 1999. I. Guskov, K. Vidimce, W. Sweldens, P. Schroeder. "Normal Meshes."
/// SIGGRAPH 2000. Tutorial, section 4.4.2.
///
///     x = b(u, v) + h n(u, v) / |n(u, v)|
///
/// b and n are linear on a triangle of the base, n from unit normals at its corners; the same formula serves
/// on both sides. Newton's iteration finds (u, v, h), in the triangle that is closest to x or in those around
/// it, and of several solutions that with the least |h|. Where there is none, or the normals from the base to
/// x meet (height times curvature reaches 1), the detail is a vector, as in DisplacementVectors, and is
/// counted. What a shape that enters adds to its details since the bind is a vector, too.
///
/// The base may bend inwards so much that the normals meet afterwards; there the surface folds over.
///
///   call         cost
///   constructor  O(n log n)
///   apply()      O(n)
class NormalDisplacements final : public DetailCoding
{
public:
    /// Where a vertex of the fine shape stands.
    struct FootPoint
    {
        int triangle = -1; ///< -1: its detail is a vector
        double u = 0, v = 0, height = 0;
    };

    /// \param fine, coarse  (n, 3) the band at rest.
    NormalDisplacements(const PointsView& fine, const PointsView& coarse,
                        std::shared_ptr<const RingRotations> rings);

    void apply(const Band& band, Points& detailed, SolveReport& report) const override;
    int vectors() const override { return vectors_; }

    const std::vector<FootPoint>& foot_points() const { return foot_points_; } ///< (n)

private:
    FootPoint foot_point_of(const Vector3& x, int closest, const PointsView& coarse,
                            const Points& normals) const;
    void normals_of(const PointsView& points, std::vector<Vector3>& of_faces, Points& normals) const;
    Vector3 place_of(const FootPoint& foot_point, const PointsView& points, const Points& normals) const;

    struct Workspace
    {
        std::vector<Vector3> of_faces;
        Points normals, entering_normals;
        std::vector<Matrix3> maps;
    };

    std::shared_ptr<const RingRotations> rings_;
    std::vector<FootPoint> foot_points_;
    int vectors_ = 0;
    mutable Pool<Workspace> workspaces_;
};

} // namespace sinew
