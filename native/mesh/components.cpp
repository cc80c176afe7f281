// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/components.h"

#include <numeric>
#include <utility>

namespace sinew {

Components connected_components(const SurfaceMesh& mesh)
{
    const int n = mesh.vertex_count();
    std::vector<int> parent(n);
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int v) {
        while (parent[v] != v)
            v = parent[v] = parent[parent[v]];
        return v;
    };
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        for (int v : loop.subspan(1)) {
            int a = root(loop[0]);
            int b = root(v);
            if (a > b)
                std::swap(a, b);
            parent[b] = a; // the lowest vertex is the root, so parts are numbered by it
        }
    }
    Components parts;
    parts.labels.assign(n, -1);
    for (int v = 0; v < n; ++v) {
        const int r = root(v);
        if (r == v)
            parts.labels[v] = parts.count++;
        else
            parts.labels[v] = parts.labels[r];
    }
    return parts;
}

} // namespace sinew
