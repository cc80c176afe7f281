// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <span>
#include <vector>

namespace sinew {

/// Orthonormal frames at vertices of one level, from the points around them. Each has two tangents
///
///     u = sum_j a_j (x_j - x_i),    v = sum_j b_j (x_j - x_i)
///
/// with fixed numbers a, b, so that frames turn with the surface; the tangents are made orthonormal by the
/// nearest orthonormal pair, and the third direction is the normal u x v.
class RingFrames
{
public:
    struct Neighbour
    {
        int vertex;
        double a, b;
    };

    /// Appends the frame of the next vertex.
    void add(std::span<const Neighbour> around)
    {
        neighbours_.insert(neighbours_.end(), around.begin(), around.end());
        offsets_.push_back(static_cast<int>(neighbours_.size()));
    }

    /// \param which     the number of the frame, in the order of add()
    /// \param fallback  the frame where the points around the vertex lie on one line or in one place
    Matrix3 at(int which, int vertex, const Points& points, const Matrix3& fallback) const;

    std::size_t bytes() const
    {
        return neighbours_.size() * sizeof(Neighbour) + offsets_.size() * sizeof(int);
    }

private:
    std::vector<int> offsets_{0};
    std::vector<Neighbour> neighbours_;
};

/// The numbers a, b of a vertex whose tangents are the derivatives of the positions along two directions in
/// its rest plane, by least squares over its edges. All zero where the edges lie on one line.
/// \param normal  of the plane, of any length.
std::vector<RingFrames::Neighbour> fitted_tangents(const Points& rest, int vertex,
                                                   std::span<const int> around, const Vector3& normal);

} // namespace sinew
