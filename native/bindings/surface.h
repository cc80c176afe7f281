// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/core/report.h"

#include <utility>

namespace sinew::bindings {

/// The arguments that every surface method's solve() takes, read and kept alive.
class SolveArguments
{
public:
    SolveArguments(const py::handle& poses, const py::object& incoming, const py::object& from_rest,
                   const py::object& start)
        : poses(bindings::poses(poses)), from_rest_(flags(from_rest, this->poses.size()))
    {
        if (!incoming.is_none()) {
            incoming_ = floats(incoming, "incoming");
            this->incoming.emplace(points<InvalidConstraint>(incoming_, "incoming"));
        }
        if (!start.is_none()) {
            start_ = floats(start, "start");
            this->start.emplace(points<InvalidConstraint>(start_, "start"));
        }
    }
    SolveArguments(const SolveArguments&) = delete;
    SolveArguments& operator=(const SolveArguments&) = delete;

    const Poses poses;
    std::optional<PointsView> incoming, start;
    const std::vector<bool>* from_rest() const { return from_rest_ ? &*from_rest_ : nullptr; }

private:
    std::optional<std::vector<bool>> from_rest_;
    FloatArray incoming_, start_;
};

/// Runs `solve(positions)` without the GIL; the positions go out as an array, with the report.
template <class Solve>
py::tuple solved(Solve&& solve)
{
    Points positions;
    SolveReport report;
    {
        const py::gil_scoped_release unlocked;
        report = solve(positions);
    }
    return py::make_tuple(to_numpy(std::move(positions)), report);
}

/// The same; unless `out` is None, the positions go there, rounded to single precision.
template <class Solve>
py::tuple solved(const py::object& out, int vertex_count, Solve&& solve)
{
    if (out.is_none())
        return solved(std::forward<Solve>(solve));
    SinglePoints single = singles(out, "out", vertex_count);
    SolveReport report;
    {
        const py::gil_scoped_release unlocked;
        thread_local Points kept; // its pages stay mapped from frame to frame
        Points positions = std::exchange(kept, {}); // taken out: a progress call may come in here again
        report = solve(positions);
        round_into(positions, single);
        kept = std::move(positions);
    }
    return py::make_tuple(out, report);
}

} // namespace sinew::bindings
