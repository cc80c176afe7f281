// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <array>
#include <span>
#include <vector>

namespace sinew {

/// One side of a face, which runs along an edge from one corner to the next.
struct HalfEdge
{
    int low, high; ///< the edge without its direction
    int from, to;
    int face;

    std::array<int, 2> edge() const { return {low, high}; }
};

/// The sides of all faces, sorted by edge and then by face. Sides between equal corners are left out.
std::vector<HalfEdge> sorted_half_edges(const SurfaceMesh& mesh);

/// (n) whether each vertex lies on an edge of one face.
std::vector<bool> border_vertices(const SurfaceMesh& mesh);

/// Calls body(sides) once per edge, with the half edges that run along it.
template <class Body>
void for_each_edge(std::span<const HalfEdge> sorted, Body&& body)
{
    for (std::size_t begin = 0, end; begin < sorted.size(); begin = end) {
        end = begin + 1;
        while (end < sorted.size() && sorted[end].edge() == sorted[begin].edge())
            ++end;
        body(sorted.subspan(begin, end - begin));
    }
}

} // namespace sinew
