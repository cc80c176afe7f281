// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/mean_value.h"

#include "native/methods/space/cage/closed_forms/mean_value_weights.h"

#include <utility>

namespace sinew {

MeanValue::MeanValue(Cage cage, const PointWeightOptions& options)
    : CageCoordinates(std::move(cage), options), geometry_(this->cage())
{
    if (this->cage().is_flat())
        flat_.emplace(this->cage(), geometry_);
}

int MeanValue::columns() const { return cage().control_count() + (flat_ ? 1 : 0); }

void MeanValue::controls(PointsView vertices, Points& controls) const
{
    controls.resize(columns(), 3);
    controls.topRows(cage().control_count()) = vertices;
    Points storage;
    if (flat_)
        flat_->controls(cage().refined(vertices, storage), false, controls.bottomRows(1));
}

void MeanValue::evaluate(int /*first*/, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    if (flat_)
        flat_->mean_value(block, rows, outside);
    else
        mean_value_weights(geometry_, block, rows, outside);
    cage().fold(rows);
}

} // namespace sinew
