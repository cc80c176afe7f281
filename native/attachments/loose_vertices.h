// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/frames/frame_kernels.h"
#include "native/attachments/host_surface.h"
#include "native/core/simd/aligned.h"
#include "native/core/types.h"

#include <optional>

namespace sinew {

/// Vertices without a face or an edge. Each rides on three vertices of its host, which take the place of a
/// patch and of its frame: with the sides b and c from the corner o of their triangle, its normal n and area
/// A,
///
///     v - o = x b + y c + z n sqrt(2 A),      v' = o' + x b' + y c' + z n' sqrt(2 A').
///
/// So a vertex on the surface stays on it, and similarities are reproduced to rounding. Cost: 10 ns per
/// vertex.
class LooseVertices
{
public:
    /// \param corners  of the mesh.
    void add(int vertex, const Triangle& corners);
    int size() const { return size_; }

    /// Finds the places of all vertices on these points.
    void measure(const PointsView& points);
    /// Writes the vertices. \param incoming  as in Attachments::move().
    void move(const std::optional<PointsView>& incoming, Points& positions) const;

private:
    int size_ = 0;
    AlignedVector<LooseSlot> slots_;
};

/// The three vertices of a host that carry a loose vertex above `place`: the corners of the triangle there,
/// unless the vertex is so high above it that a wrinkle of the surface would throw it about. Then they lie
/// about as far around the place as the vertex is above it, but at most 8 edges away, and are joined to it
/// over the host. Cost: O(1).
Triangle carriers_of(const HostSurface& host, const TriangleTree::Place& place, const Vector3& vertex);

} // namespace sinew
