// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/components.h"
#include "native/mesh/regions.h"

#include <vector>

namespace sinew {

/// The handles of each connected part. Parts do not feel each other, so everything that is averaged over
/// handles is averaged over those of one part. A part handle is a handle in one part.
struct HandleGroups
{
    std::vector<int> group;      ///< (n) the group of each vertex; -1 in a part without a handle
    std::vector<int> offsets{0}; ///< the part handles of group g are [offsets[g], offsets[g + 1])
    std::vector<int> handles;    ///< the handle of each part handle, rising within a group

    HandleGroups() = default;
    /// \param parts  of the mesh of the regions.
    HandleGroups(const Regions& regions, const Components& parts);

    int count() const { return static_cast<int>(offsets.size()) - 1; }
    int part_handle_count() const { return static_cast<int>(handles.size()); }
    /// The most part handles of a group.
    int width() const;
    /// The part handle of a handle in the part of one of its vertices.
    int part_handle(const Constraint& constraint) const;
};

} // namespace sinew
