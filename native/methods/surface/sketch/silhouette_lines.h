// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace sinew {

/// How a mesh is seen. Lengths on the screen are those of the mesh in an orthographic view, and shares of the
/// depth in a perspective one.
struct SketchView
{
    Matrix3 axes = Matrix3::Identity(); ///< rows to the right, up, and toward the viewer, orthonormal
    std::optional<Vector3> eye;         ///< the viewer of a perspective view

    /// \throw InvalidOption  the axes are not orthonormal, or a number is not finite.
    void check() const;
    /// From x to the viewer, of any length.
    Vector3 toward(const Vector3& x) const { return eye ? Vector3(*eye - x) : axes.row(2).transpose(); }
    /// By how much lengths at x are larger than on the screen; not positive behind the viewer.
    double depth(const Vector3& x) const { return eye ? axes.row(2).dot(*eye - x) : 1.0; }
    /// Where x is on the screen.
    Eigen::Vector2d seen(const Vector3& x) const
    {
        return axes.topRows<2>() * (eye ? Vector3(x - *eye) : x) / depth(x);
    }
    /// x moved along the screen, with its depth kept, so that it is seen at a place.
    Vector3 moved(const Vector3& x, const Eigen::Vector2d& place) const
    {
        return x + depth(x) * axes.topRows<2>().transpose() * (place - seen(x));
    }
};

/// A point on an edge of a triangle, (1 - share) x_a + share x_b. At a vertex, a = b.
struct LinePoint
{
    int a, b;
    double share;

    Vector3 on(const PointsView& x) const
    {
        return (1 - share) * x.row(a).transpose() + share * x.row(b).transpose();
    }
};

/// A polyline on a surface. The last point of a closed one is followed by the first.
struct SurfaceLine
{
    std::vector<LinePoint> points;
    bool closed = false;
};

/// The silhouettes of a mesh: the curves on which n . v = 0 for normals n that are linear on each triangle,
/// and the direction v to the viewer; and its borders. Hidden ones are among them: see Occlusion.
///
/// A. Hertzmann, D. Zorin. "Illustrating Smooth Surfaces." SIGGRAPH 2000, section 4. The normals at the
/// vertices are those of N. Max, "Weights for Computing Vertex Normals from Facet Normals", Journal of
/// Graphics Tools 4(2), 1999, which are exact on spheres. Lines end at borders, at edges with more than two
/// triangles, and behind the viewer. Cost: O(n log n).
std::vector<SurfaceLine> silhouette_lines(const SurfaceMesh& mesh, const SketchView& view);

/// The lines along edges that were chosen. They end where more or fewer than two of these meet.
/// \throw InvalidConstraint  a vertex is out of range.
std::vector<SurfaceLine> edge_lines(const SurfaceMesh& mesh, std::span<const std::array<int, 2>> edges,
                                    const SketchView& view);

/// A part of a line, and where its points go to lie on a stroke.
struct StrokeFit
{
    std::vector<LinePoint> points;
    Points targets; ///< (k, 3) at the depths of the points
};

/// Finds the part of one of the lines that a stroke redraws, as A. Nealen, O. Sorkine, M. Alexa, D. Cohen-Or.
/// "A Sketch-Based Interface for Detail-Preserving Mesh Editing." SIGGRAPH 2005, section 3.
///
/// A part begins and ends at the places that are nearest on the screen to the ends of the stroke; a closed
/// line has two of them, and the whole line. The part is chosen whose points are nearest, in the mean, to
/// those of the stroke at the same shares of the arc lengths on the screen, and these are their targets.
/// Parts of which more than half of the points are hidden do not count. Departs from the paper, which finds
/// the lines in an image: here they are those of the mesh, and their points need no matching.
/// \param stroke    (s, 3) points in space, of which only where they are seen counts.
/// \param nearness  how far an end may be from the line, as a share of the length of the stroke.
/// \param hidden    which points are hidden; without it, none is.
/// \return nothing where no line has a part as near as that.
/// \throw InvalidConstraint  the stroke has a point that is not finite or behind the viewer, fewer than two
///   points, or no length on the screen.
std::optional<StrokeFit> fit_stroke(const SurfaceMesh& mesh, std::span<const SurfaceLine> lines,
                                    const SketchView& view, const PointsView& stroke, double nearness = 0.5,
                                    const std::function<bool(const LinePoint&)>& hidden = {});

} // namespace sinew
