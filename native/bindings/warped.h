// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/methods/space/method.h"

#include <optional>
#include <utility>

namespace sinew::bindings {

/// What a warp of the bound points gives: `out`, a float32 array that it fills, or for None a new array.
/// \param write  (out, room) writes all points there, without the GIL, and refuses another room than theirs.
/// \throw InvalidConstraint  a position is not finite.
template <class Write>
py::object warped(const SpaceMethod& method, const py::object& out, const Write& write)
{
    const auto count = [&] {
        const py::gil_scoped_release unlocked;
        const AccessLock shared = method.reading();
        return method.points().rows();
    };
    if (!out.is_none()) {
        SinglePoints single = singles(out, "out", count());
        {
            const py::gil_scoped_release unlocked;
            write(PositionsOut(single.data()), std::optional(single.rows()));
            require_finite(single);
        }
        return out; // counts a reference, which needs the GIL
    }
    Points positions;
    {
        const py::gil_scoped_release unlocked;
        const AccessLock shared = method.reading();
        positions.resize(method.points().rows(), 3);
        write(PositionsOut(positions.data()), std::optional(positions.rows()));
        require_finite(positions);
    }
    return to_numpy(std::move(positions));
}

} // namespace sinew::bindings
