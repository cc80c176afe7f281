// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage_coordinates.h"

namespace sinew {

std::vector<std::string> CageCoordinates::changed_settings(const SpaceMethod& former) const
{
    const Cage& other = static_cast<const CageCoordinates&>(former).cage_;
    return names_of({{"cage", !(cage_ == other)}}, LinearSpaceMethod::changed_settings(former));
}

} // namespace sinew
