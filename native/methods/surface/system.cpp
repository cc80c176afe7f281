// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/system.h"

#include "native/core/errors.h"
#include "native/operators/laplacian.h"
#include "native/solvers/solved_system.h"

namespace sinew {

LinearSystem system_of(const SurfaceMethod& method, const Poses& poses)
{
    const AccessLock lock = method.reading();
    const SurfaceMesh& rest = method.rest();
    if (method.regions().handle_count() == 0)
        throw InvalidConstraint("there are no handles yet: call set_handles() first");
    SolvedSystem solved; // written to while it lives
    Points positions;
    // With an incoming shape, no method answers from a basis in place of its system.
    method.solve({.poses = poses, .incoming = view(rest.points())}, positions);
    if (solved.is_empty())
        throw InvalidOption("this method solves no linear system with its poses");
    LinearSystem system = solved.system();
    if (system.graph.cols() != rest.vertex_count()) { // the unknowns are no vertices
        system.graph = {};
        system.held = {};
        return system;
    }
    system.points = rest.points();
    if (system.mass.size() == 0)
        system.mass = divisible_mass(rest, Discretization::cotan_voronoi);
    return system;
}

} // namespace sinew
