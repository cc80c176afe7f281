// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/components.h"
#include "native/mesh/surface_mesh.h"

#include <Eigen/Geometry>

#include <vector>

namespace sinew {

/// One connected part of a mesh at rest, with indices of its own.
struct Part
{
    std::vector<int> vertices; ///< of the mesh, rising
    std::vector<Vector3> points;
    std::vector<Triangle> triangles; ///< of points
    std::vector<double> areas;       ///< of triangles
    std::vector<Triangle> bridges;   ///< of points, where pieces of it touch; no part of the surface
    double area = 0.0;
    Eigen::AlignedBox3d box;

    /// Triangles whose edges connect its pieces, too: those of the surface and the bridges.
    std::vector<Triangle> ways() const;
    double extent() const { return box.diagonal().norm(); }
    /// The point nearest the centroid of the surface; of several, the lowest.
    int centre() const;
};

/// The parts of a mesh, in the order of their labels. Cost: O(n).
std::vector<Part> parts_of(const SurfaceMesh& mesh, const Components& components);

/// A part whose border loops are closed by fans around their middles.
struct ClosedPart
{
    explicit ClosedPart(const Part& part);

    std::vector<Vector3> points;
    std::vector<Triangle> triangles;

    /// 6 |volume| / area: of a ball its diameter, of a box of side a it is a, of a rod 3 r, of a thin plate
    /// three times its thickness.
    double thickness() const;
};

} // namespace sinew
