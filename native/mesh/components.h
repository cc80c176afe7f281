// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace sinew {

/// Numbers in groups that are joined step by step. The lowest number of a group stands for it.
class JoinedGroups
{
public:
    explicit JoinedGroups(int count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

    int lowest(int i)
    {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(int a, int b)
    {
        a = lowest(a), b = lowest(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<int> parent_;
};

/// The connected parts of a mesh.
struct Components
{
    int count = 0;
    std::vector<int> labels; ///< (n) the part of each vertex; parts are numbered by their lowest vertices
};

/// Vertices are connected through faces; a vertex in no face is a part of its own. Cost: O(n).
Components connected_components(const SurfaceMesh& mesh);

} // namespace sinew
