// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/handles/map_blend.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/surface/linear/semi_regular/pulled_system.h"

#include <vector>

namespace sinew {

/// How the handles of a surface move its control mesh y. For each part,
///
///     x = T y + u,    u^T A u + sum_i s_i |(S x)_i - M_i (S y)_i|^2  least,
///
/// where A is the thin plate of the control mesh, S takes control points to the points of the smooth surface
/// that handles touch, and M_i is the pose of a handle. T is the one map of all handles of the part, or where
/// they differ the mean of their rotations (see handles/map_blend.h), moved so that it fits best to what they
/// hold. So affine motions of all handles together are exact.
///
/// A control point that is a vertex of the surface itself, as its part was not coarsened, is held exactly,
/// and its soft handles pull as those of ConstrainedSystem do. Otherwise several handles may pull at one
/// control point, and what they leave open is left to HandleBand.
class ControlMotion
{
public:
    /// \param control  the control mesh.
    /// \param S        (constraints, control vertices)
    /// \param regions  of the surface, as is the order of its constraints().
    /// \param levels   (constraints) how often the part of each was coarsened.
    /// \param group    (control vertices) of the groups of handles; -1 where none touches a part.
    /// \throw FactorizationFailed  the element of the error is a control vertex.
    void factorize(const SurfaceMesh& control, SparseRows&& S, const Regions& regions,
                   const std::vector<int>& levels, std::vector<int> group);

    /// What is kept from call to call.
    struct Workspace
    {
        RowMatrix u;
        Points base, pulled;
        PulledSystem::Workspace system;
    };

    /// \param targets         for the control points.
    /// \param[out] positions  (control vertices, 3)
    SolveReport move(const Targets& targets, const MapBlend& blend, int groups, Points& positions,
                     Workspace& work) const;

    const SpdFactor& factor() const { return system_.factor(); }

private:
    SparseRows S_;
    Points rest_; ///< S y at rest
    std::vector<Constraint> constraints_;
    std::vector<int> held_;   ///< (constraints) the control vertex that each holds, or -1
    std::vector<int> pulling_; ///< the other constraints
    std::vector<int> group_, group_of_; ///< of each control vertex; of each constraint
    PulledSystem system_;
};

/// S y
void smooth_points(const SparseRows& S, const PointsView& y, Points& points);

} // namespace sinew
