// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/same_faces.h"

#include "native/core/errors.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace sinew {

void require_same_faces(const SurfaceMesh& source, const SurfaceMesh& target)
{
    if (source.vertex_count() != target.vertex_count())
        throw InvalidMesh("the source has " + std::to_string(source.vertex_count()) +
                          " vertices, and the target " + std::to_string(target.vertex_count()));
    if (source.face_count() != target.face_count())
        throw InvalidMesh("the source has " + std::to_string(source.face_count()) +
                          " faces, and the target " + std::to_string(target.face_count()));
    std::vector<int> other;
    for (int f = 0; f < target.face_count(); ++f)
        if (!std::ranges::equal(source.face(f), target.face(f)))
            other.push_back(f);
    if (!other.empty()) {
        const std::string message =
            "faces of the target have other vertices than those of the source: " + list_some(other);
        throw InvalidMesh(message, Error::Element::face, std::move(other));
    }
}

} // namespace sinew
