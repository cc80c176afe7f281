// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Frames that move with the handles from shape to shape of a mesh.
///
/// The origin is the mean of the vertices that the handle holds or pulls. The turn is the rotation from the
/// rest shape that fits the triangles at the handle best, so a handle of a single vertex turns with the
/// triangles around it. A handle without triangles, or whose triangles lie on a line at rest, does not turn.
class HandleFrames
{
public:
    struct Frame
    {
        Matrix3 turn; ///< from rest
        Vector3 centre;
    };

    HandleFrames() = default;
    HandleFrames(const SurfaceMesh& rest, const Regions& regions);

    /// \param shape  (n, 3); null for the rest shape, where no handle is turned.
    std::vector<Frame> at(const PointsView* shape) const;

private:
    struct Member
    {
        std::vector<int> vertices; ///< that the handle holds or pulls
        std::vector<int>
            patch; ///< corners of the triangles at them, with repetitions; none: it does not turn
        Points spokes; ///< of the patch at rest, from its centre
        Vector3 rest_centre;
    };

    std::vector<Member> members_;
};

} // namespace sinew
