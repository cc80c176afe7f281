// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/ffd.h"

#include "native/core/errors.h"
#include "native/methods/space/lattice/grid/placing.h"

#include <string>
#include <utility>

namespace sinew {

Ffd::Ffd(RestGrid lattice) : SpaceMethodWith("lattice"), lattice_(std::move(lattice)) {}
Ffd::Ffd(Hexahedra lattice) : SpaceMethodWith("lattice"), lattice_(std::move(lattice)) {}

int Ffd::control_count() const
{
    return std::visit([](const auto& lattice) { return lattice.point_count(); }, lattice_);
}

void Ffd::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    PlacedPoints placed = std::visit(
        [&](const auto& lattice) { return placed_in(lattice, points, report, progress); }, lattice_);
    report.weight_bytes = placed.bytes();
    if (const auto* const cells = std::get_if<Hexahedra>(&lattice_); cells && !cells->hanging().empty())
        report.remarks.push_back("control points " + list_some(cells->hanging()) +
                                 " lie on cells that they are no corners of: the cells come apart there");
    weights_ = std::move(placed);
}

void Ffd::displace(PointsView control, PointsView base, PositionsOut out) const
{
    check_pose_of(control_name(), control, control_count());
    std::visit(
        [&](auto* positions) {
            if (const RestGrid* const grid = std::get_if<RestGrid>(&lattice_)) {
                Points moves;
                grid->moves(control, moves);
                weights_.blend([&](int cell) { return grid->cell(cell, moves.data()); }, base, positions);
            } else {
                std::vector<double> moves;
                std::get<Hexahedra>(lattice_).moves(control, moves);
                weights_.blend([&](int cell) { return Hexahedra::cell(cell, moves.data()); }, base,
                               positions);
            }
        },
        out);
}

std::vector<std::string> Ffd::changed_settings(const SpaceMethod& former) const
{
    return names_of({{"lattice", !(lattice_ == static_cast<const Ffd&>(former).lattice_)}});
}

} // namespace sinew
