// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/displacement_vectors.h"

namespace sinew {

void DisplacementVectors::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto maps = workspaces_.take([] { return std::make_unique<std::vector<Matrix3>>(); });
    detailed.resize(band.moved.rows(), 3);
    const auto has_detail = [&](int v) {
        if (band.fine.row(v) != band.coarse.row(v))
            return true;
        detailed.row(v) = band.moved.row(v);
        return false;
    };
    const auto add = [&](int v, const Matrix3& R, const Matrix3& /*sum*/) {
        detailed.row(v) =
            band.moved.row(v) + (R * (band.fine.row(v) - band.coarse.row(v)).transpose()).transpose();
    };
    if (band.at_rest)
        rings_->fit(duals_, band.moved, *maps, has_detail, add);
    else
        rings_->fit(band.coarse, band.moved, *maps, has_detail, add);
}

} // namespace sinew
