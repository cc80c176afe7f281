// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/surface/linear/semi_regular/pulled_system.h"

#include <utility>
#include <vector>

namespace sinew {

/// Brings a surface to its handles where it has come close to them. The smoothest displacement, that of a
/// thin plate, meets hard handles exactly, yields to soft ones, and ends without a crease as many edges away
/// from them as there are between two control points.
class HandleBand
{
public:
    /// \param levels  (n) how often the part of each vertex was coarsened. Parts that were not are left
    /// alone.
    /// \throw FactorizationFailed  the element of the error is a vertex of the mesh.
    void factorize(const SurfaceMesh& mesh, const Regions& regions, const std::vector<int>& levels);

    /// What is kept from call to call.
    struct Workspace
    {
        RowMatrix u;
        Points pulled;
        PulledSystem::Workspace system;
    };

    /// \param[in,out] positions  (n, 3)
    void meet(const Targets& targets, Points& positions, Workspace& work) const;

    const SpdFactor& factor() const { return system_.factor(); }

private:
    std::vector<Constraint> held_; ///< exactly
    std::vector<std::pair<int, Constraint>> ahead_; ///< those of them next to the band, by its vertices
    std::vector<Constraint> pulled_;
    std::vector<int> vertices_; ///< the vertices of the mesh around the band
    std::vector<bool> free_;    ///< whether each of them is in it
    PulledSystem system_;
};

} // namespace sinew
