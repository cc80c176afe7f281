// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"

namespace sinew {

/// Mean value coordinates of a closed triangle mesh.
///
/// T. Ju, S. Schaefer, J. Warren. "Mean Value Coordinates for Closed Triangular Meshes." ACM Transactions on
/// Graphics 24(3), 2005. Tutorial, section 5.4.
///
/// w_v(x) = sum over the triangles at v of the integral of its hat function / |p - x| over the triangle's
/// image on the unit sphere around x; weights are w_v / sum w. Sum 1 and linear precision everywhere, on the
/// cage and outside it too; may be negative where a concave cage is seen through itself.
class MeanValue : public CageCoordinates
{
public:
    explicit MeanValue(Cage cage, const CageWeightOptions& options = {})
        : CageCoordinates(std::move(cage), options)
    {
    }

protected:
    void evaluate(PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
};

} // namespace sinew
