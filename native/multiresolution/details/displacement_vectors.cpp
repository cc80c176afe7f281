// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/displacement_vectors.h"

namespace sinew {

void DisplacementVectors::apply(const Band& band, Points& detailed, SolveReport& /*report*/) const
{
    const auto maps = workspaces_.take([] { return std::make_unique<std::vector<Matrix3>>(); });
    detailed = band.moved;
    rings_->fit(
        band.coarse, band.moved, *maps, [&](int v) { return band.fine.row(v) != band.coarse.row(v); },
        [&](int v, const Matrix3& R) {
            detailed.row(v) += (R * (band.fine.row(v) - band.coarse.row(v)).transpose()).transpose();
        });
}

} // namespace sinew
