// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/handle_points/handle_points.h"

#include <array>
#include <vector>

namespace sinew {

/// The elements that weigh on a point in moving least squares.
struct MlsElements
{
    std::vector<int> points;                  ///< handle points that stand alone
    std::vector<int> groups;                  ///< handles of several points
    std::vector<std::array<int, 2>> segments; ///< between two handle points

    int numbers() const { return static_cast<int>(points.size() + 10 * (groups.size() + segments.size())); }
};

/// The weights of all elements at a point v, in the order of MlsElements: w of a point; and w, w p (3) and
/// w p p^T (6: xx, xy, xz, yy, yz, zz) of a group or a segment, with p - v for p. They sum to 1.
///
/// w = |p - v|^(-2 alpha); the points of a group share one weight evenly, and a segment has the integral over
/// its length, in units of `size`. How strongly a point is held multiplies its w, and the mean of its
/// ends that of a segment. If v lies on elements, these have all the weight; points that are held in part
/// have none if there are others.
/// \param[out] numbers  (elements.numbers())
void mls_weights(const HandlePoints& handles, const MlsElements& elements, double alpha, const Vector3& v,
                 double* numbers);

} // namespace sinew
