// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/mean_value.h"

#include "native/space/cage/closed_forms/mean_value_weights.h"

namespace sinew {

void MeanValue::evaluate(int /*first*/, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    mean_value_weights(geometry_, block, rows, outside);
}

} // namespace sinew
