// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/positive_mean_value.h"

#include "native/core/errors.h"
#include "native/methods/space/cage/visibility/visible_cage.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

PositiveMeanValue::PositiveMeanValue(Cage cage, const PositiveMeanValueOptions& options)
    : CageCoordinates(std::move(cage), options.weights), options_(options), surface_(this->cage()),
      outside_(this->cage(), options.outside)
{
    require_valid(options);
    if (options.directions % 2 != 0)
        throw InvalidOption("directions: " + std::to_string(options.directions) + " is not an even number");
    visible_ = std::make_unique<VisibleCage>(this->cage(), options.exact ? 0 : options.directions);
}

PositiveMeanValue::~PositiveMeanValue() = default;

std::vector<std::string> PositiveMeanValue::changed_settings(const SpaceMethod& former) const
{
    return changed(options_, static_cast<const PositiveMeanValue&>(former).options_,
                   CageCoordinates::changed_settings(former));
}

void PositiveMeanValue::evaluate(int, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    rows.setZero(block.rows(), cage().vertex_count());
    outside.assign(static_cast<std::size_t>(block.rows()), 0);
    VisibleCage::Scratch scratch;
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        const Vector3 x = block.row(i).transpose();
        double* row = rows.row(i).data();
        Vector3 hats;
        if (const int t = surface_.triangle_at(x, hats); t >= 0) {
            for (int k = 0; k < 3; ++k)
                row[cage().triangles()[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)]] += hats[k];
            continue;
        }
        if (std::abs(surface_.winding(x) - 1.0) > 0.5) {
            outside[static_cast<std::size_t>(i)] = 1;
            continue;
        }
        visible_->has_directions() ? visible_->sampled(x, scratch, row) : visible_->exact(x, scratch, row);
        rows.row(i) /= rows.row(i).sum();
    }
    cage().fold(rows);
    outside_.fill(block, outside, rows);
}

} // namespace sinew
