// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/handle_groups.h"

#include <algorithm>
#include <utility>

namespace sinew {

HandleGroups::HandleGroups(const Regions& regions, const Components& parts)
{
    std::vector<std::pair<int, int>> part_handles; // part, handle
    for (const auto& [vertex, handle] : regions.constraints())
        part_handles.emplace_back(parts.labels[vertex], handle);
    std::ranges::sort(part_handles);
    part_handles.erase(std::ranges::unique(part_handles).begin(), part_handles.end());

    std::vector<int> group_of_part(parts.count, -1);
    for (const auto& [part, handle] : part_handles) {
        if (group_of_part[part] < 0) {
            group_of_part[part] = count();
            offsets.push_back(offsets.back());
        }
        ++offsets.back();
        handles.push_back(handle);
    }
    group.resize(parts.labels.size());
    for (std::size_t v = 0; v < group.size(); ++v)
        group[v] = group_of_part[parts.labels[v]];
}

int HandleGroups::width() const
{
    int most = 0;
    for (int g = 0; g < count(); ++g)
        most = std::max(most, offsets[g + 1] - offsets[g]);
    return most;
}

int HandleGroups::part_handle(const Constraint& constraint) const
{
    const int g = group[constraint.vertex];
    const auto begin = handles.begin() + offsets[g], end = handles.begin() + offsets[g + 1];
    return static_cast<int>(std::lower_bound(begin, end, constraint.handle) - handles.begin());
}

} // namespace sinew
