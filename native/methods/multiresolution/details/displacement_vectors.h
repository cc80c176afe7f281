// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/ring_rotations.h"

#include <memory>
#include <utility>
#include <vector>

namespace sinew {

/// Details as one vector per vertex, which turns with the base.
///
/// D. Forsey, R. Bartels. "Hierarchical B-Spline Refinement." SIGGRAPH 1988. D. Zorin, P. Schroeder,
/// W. Sweldens. "Interactive Multiresolution Mesh Editing." SIGGRAPH 1997. Tutorial, section 4.4.1.
///
///     x_i' = b_i' + R_i (x_i - b_i)
///
/// R_i is that of ring_rotations.h, instead of a frame of the normal and one edge. Vectors keep their
/// lengths, so a base that is scaled does not scale its details, and where the base bends inwards, vectors of
/// neighbours may cross.
///
///   call         cost
///   constructor  O(n)
///   apply()      O(n), one rotation fit per vertex with a detail
class DisplacementVectors final : public DetailCoding
{
public:
    /// \param coarse  (n, 3) the base at rest.
    DisplacementVectors(std::shared_ptr<const RingRotations> rings, const PointsView& coarse)
        : rings_(std::move(rings)), duals_(rings_->duals(coarse))
    {
    }

    void apply(const Band& band, Points& detailed, SolveReport& report) const override;

private:
    std::shared_ptr<const RingRotations> rings_;
    std::vector<FaceDual> duals_; ///< at rest
    mutable Pool<std::vector<Matrix3>> workspaces_;
};

} // namespace sinew
