// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/host_surface.h"
#include "native/core/progress.h"
#include "native/mesh/trees/triangle_tree.h"

#include <memory>
#include <vector>

namespace sinew {

/// Which part an attached part rides on, and what lies beneath it.
struct Attachment
{
    int part;
    int host;
    int looks; ///< how many parts, or boxes around several, were looked at for it
    std::vector<int> samples; ///< some vertices of the part, by samples_of()
    std::vector<TriangleTree::Place> beneath; ///< the closest point of each; triangles of the HostSurface
};

/// One for each part that may carry others, else null.
using HostSurfaces = std::vector<std::unique_ptr<HostSurface>>;

/// Finds, for each part without handles, the part that it is attached to; hosts come before what is attached
/// to them. A part rides on the driven part that one of its samples is nearest to, unless the median distance
/// of its samples from a larger part is below half that from the driven ones: then on the nearest such part.
/// So an iris rides on the eye, not on the lid it touches. Empty where no driven part has an area. Cost: up
/// to 400 closest points per part, 96 for each larger part that may be nearer than the host, and O(log n)
/// looks at boxes around these.
/// \param driven    one per part.
/// \param length    that of samples_of().
/// \param surfaces  gets the surfaces that the attachments use.
std::vector<Attachment> find_hosts(const std::vector<Part>& parts, const std::vector<bool>& driven,
                                   double length, HostSurfaces& surfaces, const Progress& progress);

/// The vertices of a part that stand for it, the first ones farthest from each other.
/// \param length  parts of at most this extent get at most 100, others 400.
std::vector<int> samples_of(const Part& part, double length);

/// The places of a host that are closest to some vertices of a part. Its tree must be prepared.
std::vector<TriangleTree::Place> places_beneath(const Part& part, const std::vector<int>& samples,
                                                const HostSurface& host);

} // namespace sinew
