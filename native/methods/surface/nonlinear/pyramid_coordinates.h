// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

struct PyramidCoordinatesOptions
{
    double side = 0.05;
    bool similarity = false;
    std::shared_ptr<const SurfaceMesh> target_shape{};
    int max_iterations = 40;
    double tolerance = 1e-4;

    static constexpr auto table()
    {
        using O = PyramidCoordinatesOptions;
        return std::tuple{
            option("side", &O::side, Rebind::anew, at_least(1e-6),
                   "how firmly rings keep their edges and angles, in comparison with the height of the "
                   "vertex over them"),
            option("similarity", &O::similarity, Rebind::anew,
                   "whether rings may also grow and shrink, from half to twice their size"),
            option("target_shape", &O::target_shape, Rebind::anew,
                   "None, or a SurfaceMesh with the same faces, to which solve(morph=t) goes"),
            iteration_limit(&O::max_iterations), stopping_tolerance(&O::tolerance)};
    }
};

/// Pyramid coordinates: each vertex keeps its place over the ring of its neighbours, as the tip of a pyramid.
///
/// A. Sheffer, V. Kraevoy. "Pyramid Coordinates for Morphing and Deformation." 3DPVT 2004.
/// V. Kraevoy, A. Sheffer. "Mean-Value Geometry Encoding." IJSM 12(1), 2006.
///
/// The ring of vertex i is projected along its normal. There the vertex is the mean of its neighbours with
/// mean-value weights w_ij, and above it stands at a height: p_i - sum_j w_ij p_j = d_i, along the normal.
/// Weights, heights and projected edges are the coordinates; no rigid motion changes them. For base points p
/// (the incoming shape, or the rest shape) the deformed points x and one rotation R_i per vertex minimise
///
///     E = 1/2 sum_i k_i |x_i - sum_j w_ij x_j - R_i d_i|^2
///       + 1/2 sum_i c_i sum_j |(x_j - x_i) - R_i (p_j - p_i)|^2
///
/// with the weights w of the rest shape, c_i = side / valence, and k_i = A / (866 l_i^2), where A is the
/// area of the part and l_i^2 the mean square of the ring's edges: 1 for a part of 1000 even triangles'
/// vertices. So bending resists as much on a fine mesh as on a coarse one. k_i is bounded such that
/// k_i |d_i|^2 <= 2 side l_i^2 at rest; otherwise a crease would resist more on a finer mesh. With
/// `similarity`, s_i R_i takes the place of R_i, 1/2 <= s_i <= 2.
///
/// Morphing mixes the coordinates of the base with those of the target shape, (1 - t) of one and t of the
/// other, and reconstructs; the two rings of a vertex are turned onto each other before. Handles take their
/// vertices along, by a rigid motion and a rest. Parts without a handle are morphed, too, and lie where they
/// fit both shapes best. So t = 0 gives the base and t = 1 the target shape, both moved by the handles.
///
/// Departs from the papers: rotations take the place of normals that are computed again and again, which
/// needs one factor only; there the lengths of projected edges are kept by a term of their own. The start is
/// that of a cascade of clustered graphs instead of the shape of the last frame. At open borders and edges of
/// three faces weights are equal, as they are where the projection of a ring overlaps: see folded_rings().
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   O(n)
///   set_handles()  another set of handles        one factorisation, and those of the cascade
///   solve()        the handles moved             as much as 3 to 5 iterations for the start, then its
///                                                iterations: one solve for x, y and z and n rotation fits
///                                                each
class PyramidCoordinates final : public SurfaceMethodWith<PyramidCoordinatesOptions>
{
public:
    /// \throw InvalidOption  side or tolerance is negative or not finite, side is 0, or max_iterations < 1.
    /// \throw InvalidMesh    the target shape has other faces; they are named.
    explicit PyramidCoordinates(const SurfaceMesh& rest, const PyramidCoordinatesOptions& options = {});

    /// The vertices whose ring overlaps in its projection, at rest or in the target shape: they have equal
    /// weights. None before set_handles().
    std::vector<int> folded_rings() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
