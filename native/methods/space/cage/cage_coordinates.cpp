// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage_coordinates.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sinew {

std::vector<std::string> CageCoordinates::changed_settings(const SpaceMethod& former) const
{
    const Cage& other = static_cast<const CageCoordinates&>(former).cage_;
    std::vector<std::string> names = LinearSpaceMethod::changed_settings(former);
    std::ranges::copy(cage_.smoothing().changed_from(other.smoothing()), std::back_inserter(names));
    return names_of({{"cage", !(cage_.given() == other.given())}}, std::move(names));
}

} // namespace sinew
