// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/components.h"
#include "native/riders/part.h"
#include "native/riders/seat.h"

#include <array>
#include <vector>

namespace sinew {

/// Parts of which some are several parts that touch.
struct JoinedParts
{
    Components parts;
    std::vector<std::array<int, 2>> links; ///< vertices of the mesh, one for each two parts that touch

    /// The parts themselves, with the links in them.
    std::vector<Part> of(const SurfaceMesh& mesh) const;
};

/// Joins the parts that ride on the same part and touch each other, so that a row of teeth stays a row. Parts
/// touch where a vertex of one is nearer to the surface of the other than 2 % of the extent of the smaller
/// one. Cost: O(n log n), and a closest triangle for each vertex within that distance of another part's box.
/// \param all  the parts themselves; those without an area are never joined.
JoinedParts joined_where_they_touch(const Components& parts, const std::vector<Part>& all,
                                    const std::vector<Seat>& seats);

} // namespace sinew
