// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_coordinates.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <chrono>

namespace sinew {

CageReport CageCoordinates::bind(PointsView points, const Progress& progress)
{
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point begin) {
        return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    const auto begin = Clock::now();
    const int count = static_cast<int>(points.rows());
    std::vector<int> bad;
    for (int i = 0; i < count; ++i)
        if (!points.row(i).allFinite())
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidConstraint("points " + list_some(bad) + " are not finite", Error::Element::vertex, bad);

    Points rest_controls;
    controls(view(cage_.rest().points()), rest_controls);
    PointWeights weights(count, rest_controls, cage_.vertex_count(), options_);
    const struct Release
    {
        CageCoordinates& method;
        ~Release() { method.release(); }
    } at_the_end{*this};
    const double prepared = prepare(points, progress);
    std::vector<char> outside(static_cast<std::size_t>(count), 0);
    // From tick to tick a tenth of a second or so; what a point gets does not depend on where they fall.
    const int block = block_size();
    int slab = 4 * block;
    for (int first = 0; first < count;) {
        progress.tick(prepared + (1.0 - prepared) * first / count, "computing weights");
        const auto slab_begin = Clock::now();
        const int some = std::min(slab, count - first);
        parallel_chunks(some, block, [&](int from, int to) {
            RowMatrix rows;
            std::vector<char> out;
            const PointsView chunk(points.data() + 3 * static_cast<std::ptrdiff_t>(first + from), to - from,
                                   3);
            evaluate(first + from, chunk, rows, out);
            weights.set_rows(first + from, rows);
            std::copy(out.begin(), out.end(), outside.begin() + first + from);
        });
        weights.check_memory();
        first += some;
        if (since(slab_begin) < 0.05)
            slab = std::min(2 * slab, 1 << 20);
    }

    CageReport report;
    for (int i = 0; i < count; ++i)
        if (outside[static_cast<std::size_t>(i)])
            report.outside.push_back(i);
    if (!report.outside.empty() && !reaches_outside())
        throw InvalidConstraint("points " + list_some(report.outside) + " lie outside the cage",
                                Error::Element::vertex, report.outside);
    report.point_count = count;
    report.dropped = weights.dropped();
    report.weight_bytes = weights.bytes();
    finish(report);
    progress.tick(1.0, "computing weights");
    points_ = points;
    rest_controls_ = std::move(rest_controls);
    weights_ = std::move(weights);
    bound_ = true;
    report.seconds = since(begin);
    return report;
}

void CageCoordinates::moves(PointsView vertices, Points& moves) const
{
    if (!bound_)
        throw InvalidConstraint("no points are bound to the cage: call bind() first");
    cage_.check_pose(vertices);
    controls(vertices, moves);
    moves -= rest_controls_;
}

void CageCoordinates::warp(PointsView vertices, Points& positions) const
{
    Points moved;
    moves(vertices, moved);
    positions.resize(points_.rows(), 3);
    weights_.apply(moved, points_, positions.data());
}

template <class Real>
void CageCoordinates::warp(PointsView vertices, Real* positions) const
{
    Points moved;
    moves(vertices, moved);
    weights_.apply(moved, points_, positions);
}

template void CageCoordinates::warp(PointsView, float*) const;
template void CageCoordinates::warp(PointsView, double*) const;

} // namespace sinew
