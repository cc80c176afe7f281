// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/rows/row_table.h"
#include "native/mesh/regions.h"

#include <vector>

namespace sinew {

// For tables whose points are the vertices of a mesh.

/// True for vertices that are not unknowns: constrained, or in a component without handles.
std::vector<bool> held_vertices(const Regions& regions);

/// Adds the soft pulls of the handles, in units of each vertex's own diagonal entry of the table's Hessian.
void add_pulls(const Regions& regions, RowTable& rows);

/// Where the handles want the vertices that they hold or pull.
struct Goals
{
    Points held; ///< (n, 3) the targets of held vertices, and the base of the others
    Points pulls; ///< (pulls, 3) the targets of the soft pulls, as RowProblem takes them

    void set(const Regions& regions, const Targets& targets);
};

/// Targets in another unit of length, in which a method computes. Kept from one solve to the next, it is not
/// allocated again.
class TargetsInUnit
{
public:
    /// \param given  in object space.
    /// \param rest   (n, 3) in units of `unit`.
    /// \return what is valid as long as this object, the points of `rest` and those of `given` are.
    Targets of(const Targets& given, const PointsView& rest, double unit);

private:
    Poses poses_;
    Points incoming_;
};

} // namespace sinew
