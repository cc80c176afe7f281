// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/components.h"

namespace sinew {

Components connected_components(const SurfaceMesh& mesh)
{
    const int n = mesh.vertex_count();
    JoinedGroups groups(n);
    for (int f = 0; f < mesh.face_count(); ++f)
        for (int v : mesh.face(f).subspan(1))
            groups.join(mesh.face(f)[0], v);
    Components parts;
    parts.labels.assign(n, -1);
    for (int v = 0; v < n; ++v) {
        const int first = groups.lowest(v);
        parts.labels[v] = first == v ? parts.count++ : parts.labels[first];
    }
    return parts;
}

} // namespace sinew
