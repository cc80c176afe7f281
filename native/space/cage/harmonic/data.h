// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage.h"

#include <array>
#include <vector>

namespace sinew {

/// What harmonic coordinates are on a cage's triangle: its hats, and on the half of a plane convex quad, as
/// `diagonal` >= 0 tells, the product of those of its corners `diagonal` and the next, shared out to the
/// quad's. That is the bilinear function on parallelograms and linearly precise on every plane convex quad.
struct HarmonicData
{
    Triangle vertex;
    int diagonal = -1;
    std::array<int, 4> quad{};
    std::array<double, 4> share{};

    /// entry(vertex, value) for what the data consist of where the triangle's hats are these.
    template <class Entry>
    void each(const Vector3& hats, Entry&& entry) const
    {
        for (int k = 0; k < 3; ++k)
            entry(vertex[k], hats[k]);
        if (diagonal >= 0)
            for (int i = 0; i < 4; ++i)
                entry(quad[i], hats[diagonal] * hats[(diagonal + 1) % 3] * share[i]);
    }
    /// row (c) += factor times the data there.
    void add(const Vector3& hats, double factor, double* row) const
    {
        each(hats, [&](int v, double value) { row[v] += factor * value; });
    }
};

/// Of all triangles of a cage, none of them flat.
std::vector<HarmonicData> harmonic_data(const Cage& cage);

} // namespace sinew
