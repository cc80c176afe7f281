// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/rows/goals.h"

namespace sinew {

std::vector<bool> held_vertices(const Regions& regions)
{
    std::vector<bool> held(regions.vertex_count());
    for (int v = 0; v < regions.vertex_count(); ++v)
        held[v] = !regions.is_free(v);
    return held;
}

void add_pulls(const Regions& regions, RowTable& rows)
{
    if (regions.soft().empty())
        return;
    std::vector<double> diagonal(rows.point_count(), 0.0);
    for (const RowTable::Row& row : rows.rows())
        for (const RowTable::Term& term : rows.terms(row))
            diagonal[term.point] += row.weight * term.coefficient * term.coefficient;
    for (const SoftConstraint& soft : regions.soft())
        rows.pull(soft.vertex, soft.stiffness() * (diagonal[soft.vertex] > 0 ? diagonal[soft.vertex] : 1.0));
}

void Goals::set(const Regions& regions, const Targets& targets)
{
    held = targets.base();
    for (int v = 0; v < regions.vertex_count(); ++v)
        if (const int handle = regions.hard(v); handle >= 0)
            held.row(v) = targets.position(v, handle).transpose();
    pulls.resize(static_cast<Eigen::Index>(regions.soft().size()), 3);
    for (std::size_t k = 0; k < regions.soft().size(); ++k)
        pulls.row(static_cast<Eigen::Index>(k)) =
            targets.position(regions.soft()[k].vertex, regions.soft()[k].handle).transpose();
}

Targets TargetsInUnit::of(const Targets& given, const PointsView& rest, double unit)
{
    poses_ = given.poses;
    for (Pose& pose : poses_)
        pose.col(3) /= unit;
    Targets targets{poses_, rest, given.incoming, given.from_rest};
    if (given.incoming && unit != 1.0) {
        incoming_ = *given.incoming / unit;
        targets.incoming.emplace(view(incoming_));
    }
    return targets;
}

} // namespace sinew
