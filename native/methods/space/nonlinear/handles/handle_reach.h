// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/trees/box_tree.h"
#include "native/methods/space/nonlinear/handles/handle_control.h"
#include "native/methods/space/weights/blended_maps.h"

#include <vector>

namespace sinew {

/// How points follow the handles themselves: a point of a handle exactly, and points around it the less the
/// farther away they are, so that the shape stays smooth there. Nodes and cells alone would miss handles by
/// some thousandths of the size.
class HandleReach
{
public:
    using Shares = std::vector<BlendedMaps::Share>;

    /// \param held    (c, 3) the points of the handles.
    /// \param shares  (c) what they follow besides. Only points that follow one of these are reached, so that
    ///                the reach does not jump from one limb to the next.
    /// \param radius  how far it goes.
    HandleReach(const HandleControl& handles, Points held, const std::vector<Shares>& shares, double radius);

    /// Adds shares of the handles, whose maps are numbered from `first` on, to those of a point. With f = 1 -
    /// 3 r^2 + 2 r^3 at the distance r, in radii, to the nearest point of a handle, times the weight of that
    /// point, and t = f / (1 - f), a handle gets t / (1 + sum t).
    void add_to(Shares& shares, const Vector3& point, int first) const;

private:
    /// f of a handle at a point.
    double strength(int handle, const Shares& shares, const Vector3& point) const;

    const HandleControl& handles_;
    Points held_;
    const std::vector<Shares>& shares_;
    double radius_;
    std::vector<BoxTree> trees_; ///< of the points of each handle
};

/// (c) how far each point of a handle takes hold of what is nearest to it: fully, unless another handle is
/// less than half as far from that. With r the distance from the point to its `carriers` row, and s the
/// distance from there to the nearest point of another handle plus `radius`, it is 2 - r / s, from 0 to 1.
std::vector<double> holds(const HandlePoints& handles, const Points& held, const Points& carriers,
                          double radius);

/// `motions`, and after them the one of a handle that rests. What no handle is near follows that one.
std::vector<HeldMotion> with_rest(std::vector<HeldMotion> motions);

/// Whether two pieces of the shape hold together: the gap between them is at most a quarter of the diagonal
/// of the box around the larger one. \param one, other  places all over the pieces.
bool are_near(double gap, const Points& one, const Points& other);

/// The displacements of the handles for BlendedMaps, about the centre of their coordinates.
void append_displacements(const std::vector<HeldMotion>& motions, Poses& maps);

} // namespace sinew
