// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct HierarchicalSmoothingOptions
{
    int levels = 64;
    int relaxations = 4;

    static constexpr auto table()
    {
        using O = HierarchicalSmoothingOptions;
        return std::tuple{
            option("levels", &O::levels, Rebind::update, at_least(0),
                   "the most levels that the free vertices are thinned out by; 0 solves on the mesh "
                   "itself, as a thin plate, and turns no details"),
            option("relaxations", &O::relaxations, Rebind::update, at_least(0),
                   "sweeps on each level after its vertices have come back")};
    }
};

/// Hierarchical smoothing: the handles move a coarse mesh, which gets its vertices back level by level; each
/// level is relaxed, and its details ride on it.
///
/// I. Guskov, W. Sweldens, P. Schroeder. "Multiresolution Signal Processing for Meshes." SIGGRAPH 1999.
/// Tutorial, section 4.3.
///
/// The bind thins out the free vertices, a set of vertices that are no neighbours per level; vertices that
/// handles touch stay on all levels. A frame
///
///   1. moves the coarsest level: x = T y + u, with the smoothest displacement u between the handles (see
///      pyramid/coarse_motion.h);
///   2. level by level, puts vertices back and relaxes them and their neighbours by the least second
///      differences, whose coefficients are those of the rest shape (see pyramid/relaxed_level.h). They are
///      zero for what is linear on two triangles unfolded into a plane. So planar regions have no details,
///      which uniform Laplacians would give them;
///   3. adds the details that the incoming shape, or the rest shape, has beyond its own relaxed level, in
///      frames of the relaxed level.
///
/// Departs from the paper: levels are sets of vertices, so that they are computed in parallel; coarse levels
/// take their vertices from the finest one without smoothing them first; second differences are weighted by
/// heights of triangles; relaxation is a damped Jacobi sweep; the coarsest level is solved for exactly.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        the hierarchy, O(n log n); one factorisation of its
///                                                coarsest level
///   solve()        the handles moved             one small solve, and a few sweeps over all levels, which
///                                                together have about six times the vertices of the mesh;
///                                                twice that for a shape that enters
///
/// Rigid motions of all handles are reproduced; with levels = 0, affine ones. Details turn with the coarser
/// shape, that itself is moved as a thin plate: handles that are turned by more than about a right angle
/// against each other flatten it between them.
class HierarchicalSmoothing final : public SurfaceMethodWith<HierarchicalSmoothingOptions>
{
public:
    /// \throw InvalidOption  levels or relaxations < 0.
    explicit HierarchicalSmoothing(const SurfaceMesh& rest, const HierarchicalSmoothingOptions& options = {});

    /// The number of levels that the last bind made, without the coarsest one.
    int level_count() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
