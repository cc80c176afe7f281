// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_coordinates.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <chrono>

namespace sinew {

namespace {

constexpr int block = 256;          // points a block: its weights stay in the cache
constexpr int slab = 16 * block;    // points between two ticks

} // namespace

CageReport CageCoordinates::bind(PointsView points, const Progress& progress)
{
    const auto begin = std::chrono::steady_clock::now();
    const int count = static_cast<int>(points.rows());
    std::vector<int> bad;
    for (int i = 0; i < count; ++i)
        if (!points.row(i).allFinite())
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidConstraint("points " + list_some(bad) + " are not finite", Error::Element::vertex, bad);

    CageWeights weights(count, columns(), options_);
    const double prepared = prepare(points, progress);
    std::vector<char> outside(static_cast<std::size_t>(count), 0);
    for (int first = 0; first < count; first += slab) {
        progress.tick(prepared + (1.0 - prepared) * first / count, "computing weights");
        parallel_chunks(std::min(slab, count - first), block, [&](int from, int to) {
            RowMatrix rows;
            std::vector<char> out;
            const PointsView part(points.data() + 3 * static_cast<std::ptrdiff_t>(first + from), to - from,
                                  3);
            evaluate(part, rows, out);
            weights.set_rows(first + from, rows);
            std::copy(out.begin(), out.end(), outside.begin() + first + from);
        });
    }
    weights.finish();

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
    weights_ = std::move(weights);
    bound_ = true;
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
}

void CageCoordinates::warp(PointsView vertices, Points& positions) const
{
    if (!bound_)
        throw InvalidConstraint("no points are bound to the cage: call bind() first");
    cage_.check_pose(vertices);
    Points columns;
    controls(vertices, columns);
    weights_.apply(columns, positions);
}

} // namespace sinew
