// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/handles/constrained_system.h"
#include "native/handles/map_blend.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <functional>
#include <vector>

namespace sinew {

/// How handles move the coarsest level of a hierarchy, y: for each part,
///
///     x = T y + u,    sum_e (D_e u)^2 + 1e-8 u^T L u + sum_i s_i |x_i - t_i|^2  least,
///
/// with the second differences D_e and L of second_differences.h at rest. T is the one map of all handles of
/// the part, or where they differ the mean of their rotations (see handles/map_blend.h), moved so that it
/// fits best to what they hold. So affine motions of all handles together are exact, and turns of handles are
/// seen from the middle of them.
///
///   factorize()  another level or other handles   one factorisation
///   move()       the handles moved                one solve for x, y and z
class CoarseMotion
{
public:
    /// Takes another level, and then calls `completed`. Leaves everything as it was if one of the two throws.
    /// \param handles  of the level's own vertices.
    /// \param group    (n) the part of each vertex in the groups of the handles; -1 where none touches it.
    /// \return the number of faces with a triangle of (nearly) no area.
    /// \throw FactorizationFailed  with a vertex of the level; InvalidConstraint as Regions.
    int factorize(const SurfaceMesh& level, std::vector<Handle> handles, std::vector<int> group,
                  const std::function<void()>& completed);

    /// \param targets          for the level's own vertices.
    /// \param[out] positions   (n, 3)
    SolveReport move(const Targets& targets, const MapBlend& blend, int groups, Points& positions) const;

    const Regions& regions() const { return regions_; }
    void report(BindReport& report) const { system_.report(report); }

private:
    Regions regions_;
    std::vector<Constraint> constraints_;
    std::vector<int> group_;
    SparseMatrix energy_; ///< without the pulls of soft handles
    ConstrainedSystem system_;
};

} // namespace sinew
