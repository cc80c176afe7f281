// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/subdivision/subdivision_surface.h"

#include <array>
#include <string>
#include <tuple>
#include <vector>

namespace sinew {

/// Which surface of a cage moves points.
enum class CageSmooth {
    off,       ///< its faces
    automatic, ///< its smooth surface, refined until it is close enough to the limit
    levels     ///< its smooth surface, refined as often as is asked for
};
constexpr auto choices(CageSmooth)
{
    return std::array{Choice{"off", CageSmooth::off}, Choice{"automatic", CageSmooth::automatic},
                      Choice{"levels", CageSmooth::levels}};
}

struct CageSmoothing
{
    CageSmooth smooth = CageSmooth::off;
    int levels = 2; ///< for CageSmooth::levels
    std::vector<std::array<int, 2>> crease_edges;
    std::vector<double> crease_sharpness;
    std::vector<int> corner_vertices;
    std::vector<double> corner_sharpness;
    BoundarySmooth boundary_smooth = BoundarySmooth::all; ///< of the outline of a flat cage

    static constexpr auto table()
    {
        using O = CageSmoothing;
        return std::tuple{
            option("smooth", &O::smooth, Rebind::anew,
                   "'off'; or the limit surface of the cage moves the points, by Catmull and Clark's rules: "
                   "refined as often as levels says, or if 'automatic' until it is within 1/1000 of the "
                   "cage's size of the limit. A frame still has one column per vertex of the cage"),
            option("levels", &O::levels, Rebind::anew, between(1, 6),
                   "how often faces are split for smooth='levels'"),
            option("boundary_smooth", &O::boundary_smooth, Rebind::anew,
                   "'all' or 'preserve_corners': the outline of a smooth flat cage")};
    }
    /// Names of what differs.
    std::vector<std::string> changed_from(const CageSmoothing& other) const;
};

/// The limit surface of a cage by Catmull and Clark's rules, as a mesh of quads with its vertices on it.
///
/// E. Catmull, J. Clark. "Recursively Generated B-Spline Surfaces on Arbitrary Topological Meshes."
/// Computer-Aided Design 10(6), 1978. Tutorial, section 5.4.
///
/// A vertex of this mesh is a sum S c of the cage's own vertices c. So weights W of its vertices are weights
/// W S of those of the cage. The distance between the mesh and the limit surface falls by a factor of four
/// per level. CageSmooth::automatic takes the first level where error() is below 1/1000 of the size of the
/// cage, but no more than 5 levels or 20,000 quads.
class SmoothCage
{
public:
    /// Cost: 1 us per vertex of this mesh; four times that for CageSmooth::automatic.
    /// \throw InvalidMesh, InvalidOption, OutOfMemory  as SubdivisionSurface.
    SmoothCage(const SurfaceMesh& control, const CageSmoothing& smoothing);

    int level() const { return options_.level; }
    /// How far the quads, as bilinear patches, are from the limit surface: 4/3 of the largest distance of
    /// their middles and sides from those of the next level. In the unit of the control mesh.
    double error() const;
    /// (vertices, control points) S.
    const SparseRows& matrix() const { return surface_.matrix(); }
    /// (vertices, control points) the weights of plain, bilinear splitting: where each vertex lies on the
    /// faces of the cage.
    const SparseRows& places() const { return places_; }
    /// The face of the cage that a quad is a part of.
    int control_face(int quad) const { return control_faces_[static_cast<std::size_t>(quad)]; }

    /// (vertices, 3) the vertices of the mesh for posed control points.
    Points refined(PointsView control) const;
    /// The mesh for posed control points.
    SurfaceMesh mesh(PointsView control) const;
    /// Takes weights of the vertices, the first columns of some rows, to weights of the control points. Other
    /// columns follow them as before.
    void fold(RowMatrix& rows) const;

private:
    SurfaceMesh control_;
    SubdivisionOptions options_;
    SubdivisionSurface surface_;
    SparseRows places_;
    std::vector<int> control_faces_;
};

/// rows (r, k) times a sparse (k, c), summed in the order of k, so that the bits depend on nothing else.
/// \param first  the column of `rows` that belongs to row 0 of the matrix.
void add_product(const RowMatrix& rows, Eigen::Index first, const SparseRows& matrix,
                 Eigen::Ref<RowMatrix> sums);

} // namespace sinew
