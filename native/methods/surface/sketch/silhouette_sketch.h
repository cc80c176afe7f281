// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/surface/sketch/silhouette_lines.h"
#include "native/operators/laplacian.h"
#include "native/solvers/spd_factor.h"

#include <vector>

namespace sinew {

struct SilhouetteSketchOptions
{
    Discretization laplacian = Discretization::cotan_voronoi;
    int refits = 2;         ///< how often the rotations of the details are estimated
    double sharpness = 0.0; ///< the curvature that is added along the line, as a multiple of its own
    double weight = 0.99;   ///< of the targets, at least 0 and less than 1
};

/// Laplacian editing of a surface on which a line is drawn anew: its silhouette in a view, or a feature.
///
/// A. Nealen, O. Sorkine, M. Alexa, D. Cohen-Or. "A Sketch-Based Interface for Detail-Preserving Mesh
/// Editing." SIGGRAPH 2005, sections 3 and 5. Tutorial, section 4.5.2.
///
/// With the rest shape x, its differential coordinates delta = M^-1 L x, points p_k = B_k x on edges of the
/// line, and their targets t_k, it minimises
///
///     E(x') = 1/2 sum_i m_i |(M^-1 L x')_i - c_i T_i delta_i|^2 + 1/2 sum_k s_k |B_k x' - t_k|^2
///
/// with L and M of operators/laplacian.h and s_k = w / (1 - w) B_k diag(L M^-1 L). First T_i = 1, then
/// `refits` times the rotation that fits best to the edges at vertex i, as in LaplacianEditing; c_i is 1 plus
/// the sharpness at the ends of the edges with a point p_k, and 1 elsewhere. Held vertices stay, and so does
/// each part without a free vertex of the line.
///
/// Departs from the paper: the rotations are estimated rather than linearised, L is that of cotangents and
/// areas unless the options say otherwise, and vertices do not slide along the surface to the line first.
///
///   call         repeat it when ...                         cost
///   constructor  another line, other held vertices or mesh  one factorisation of the free vertices
///   solve()      the stroke moved                           one solve for x, y and z and one per refit, each
///                                                           with a rotation fit per vertex
class SilhouetteSketch
{
public:
    /// \param line  points on edges of the mesh; only neighbours keep the factor sparse.
    /// \param held  (h) vertices that stay.
    /// \throw InvalidConstraint    a vertex is out of range, a share is not in 0..1, or all vertices of the
    ///   line are held.
    /// \throw InvalidOption        refits < 0, sharpness < -1, or a weight out of its range.
    /// \throw FactorizationFailed  the element is a vertex.
    SilhouetteSketch(const SurfaceMesh& rest, std::vector<LinePoint> line, const std::vector<int>& held,
                     const SilhouetteSketchOptions& options = {});

    /// \param targets        (k, 3) of the points of the line.
    /// \param[out] positions  (n, 3)
    /// \throw InvalidConstraint  another number of targets, or one is not finite.
    void solve(const PointsView& targets, Points& positions) const;

    int vertex_count() const { return static_cast<int>(rest_.rows()); }
    int free_count() const { return static_cast<int>(free_.size()); }
    int factorizations() const { return factor_.factorizations(); }

private:
    SilhouetteSketchOptions options_;
    Points rest_;
    std::vector<LinePoint> line_;
    std::vector<double> pull_; ///< s_k
    SparseMatrix L_;
    Points delta_;
    VectorX scale_;         ///< (n) c_i
    std::vector<int> free_; ///< the unknowns
    std::vector<int> place_; ///< (n) of each vertex among them, or -1
    SpdFactor factor_;
};

} // namespace sinew
