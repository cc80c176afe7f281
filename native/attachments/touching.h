// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/find_hosts.h"
#include "native/attachments/part.h"
#include "native/core/progress.h"
#include "native/mesh/components.h"

#include <vector>

namespace sinew {

/// Parts, their labels, and what those that are not driven ride on.
struct HostedParts
{
    Components labels;
    std::vector<Part> parts;
    std::vector<Attachment> attachments; ///< hosts before their attached parts
    HostSurfaces surfaces;
};

/// Joins the parts that ride on the same part and touch each other, so that a row of teeth stays a row. Parts
/// touch where they cross, or where a vertex of one is nearer to the surface of the other than 2 % of the
/// extent of the smaller one. A joined part has a bridge at each such place, and the host of its pieces.
/// Parts without an area are never joined; and where none touch, nothing changes.
///
/// A part that touches the attached part on which it rides, and is at least half as long, rides on that one's
/// host instead: so cards of hair are all on the head, where some are nearer to other cards.
///
/// Cost: O(n log n), and for each two parts whose boxes are that near, a look at what each has in the box of
/// the other one.
/// \param length  that of find_hosts().
/// \return what each of the parts rides on, by the labels before.
std::vector<int> join_where_they_touch(const SurfaceMesh& mesh, HostedParts& hosted, double length,
                                       const Progress& progress);

} // namespace sinew
