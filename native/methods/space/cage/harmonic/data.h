// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"

#include <array>
#include <vector>

namespace sinew {

/// The values of harmonic coordinates on a triangle of the cage. They are the hat functions of its corners.
/// If the triangle is half of a plane convex quad, `diagonal` is >= 0, and multiples of a product are added
/// for the four corners of the quad: the product of the hats at corner `diagonal` and at the next one. This
/// gives the bilinear function on parallelograms, and linear precision on every plane convex quad.
struct HarmonicData
{
    Triangle vertex;
    int diagonal = -1;
    std::array<int, 4> quad{};
    std::array<double, 4> share{};

    /// Calls entry(vertex, value) for each part of the data at the point with these hat values. A vertex may
    /// come several times.
    template <class Entry>
    void each(const Vector3& hats, Entry&& entry) const
    {
        for (int k = 0; k < 3; ++k)
            entry(vertex[k], hats[k]);
        if (diagonal >= 0)
            for (int i = 0; i < 4; ++i)
                entry(quad[i], hats[diagonal] * hats[(diagonal + 1) % 3] * share[i]);
    }
    /// row (c) += factor * data at the point with these hat values.
    void add(const Vector3& hats, double factor, double* row) const
    {
        each(hats, [&](int v, double value) { row[v] += factor * value; });
    }
};

/// The data on all triangles of a cage. None of them may be flat.
std::vector<HarmonicData> harmonic_data(const Cage& cage);

} // namespace sinew
