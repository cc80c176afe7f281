// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/method.h"
#include "native/solvers/linear_system.h"

namespace sinew {

/// The linear system with which a solve for these poses ends. Its unknowns are displacements of free vertices from the
/// rest shape.
/// \throw InvalidConstraint  the method has no handles yet, or the poses do not fit them.
/// \throw InvalidOption      the method solves no linear system with its poses.
LinearSystem system_of(const SurfaceMethod& method, const Poses& poses);

} // namespace sinew
