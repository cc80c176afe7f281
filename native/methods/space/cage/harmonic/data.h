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
///
/// With a smooth cage, each of these values is a sum of values of control points.
struct HarmonicData
{
    /// A multiple of the hat at corner 0, 1 or 2, or if `part` is 3 of the product, in the data of a control
    /// point. One may come several times.
    struct Entry
    {
        int control, part;
        double share;
    };
    std::vector<Entry> entries;
    int diagonal = -1;

    /// Calls entry(control, value) for each part of the data at the point with these hat values.
    template <class Visit>
    void each(const Vector3& hats, Visit&& visit) const
    {
        const double values[4] = {hats[0], hats[1], hats[2],
                                  diagonal < 0 ? 0.0 : hats[diagonal] * hats[(diagonal + 1) % 3]};
        for (const Entry& entry : entries)
            visit(entry.control, entry.share * values[entry.part]);
    }
    /// row (c) += factor * data at the point with these hat values.
    void add(const Vector3& hats, double factor, double* row) const
    {
        each(hats, [&](int control, double value) { row[control] += factor * value; });
    }
};

/// The data on all triangles of a cage. None of them may be flat.
std::vector<HarmonicData> harmonic_data(const Cage& cage);

} // namespace sinew
