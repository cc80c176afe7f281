// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/methods/surface/contract.h"

/// Calls that the tests of every surface method share.
namespace sinew::calls {

using Method = std::shared_ptr<SurfaceMethod>;

inline Method bound(const SurfaceVariant& variant, const SurfaceMesh& mesh,
                    const std::vector<Handle>& handles)
{
    Method method = variant.make(mesh);
    method->set_handles(handles);
    return method;
}

inline Points solve(const SurfaceMethod& method, const Poses& poses, SolveRequest request = {})
{
    Points positions;
    request.poses = poses;
    method.solve(request, positions);
    return positions;
}

} // namespace sinew::calls
