// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/linear_method.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/methods/space/weights/points_outside.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sinew {

void LinearSpaceMethod::compute(PointsView given, SpaceReport& report, const Progress& progress)
{
    using Clock = std::chrono::steady_clock;
    Points storage;
    const PointsView points = normalized(given, storage);
    const int count = static_cast<int>(points.rows());
    Points rest_controls;
    controls(rest_control(), rest_controls);
    PointWeights weights(count, rest_controls, static_cast<int>(rest_control().rows()), weight_options_);
    const struct Release
    {
        LinearSpaceMethod& method;
        ~Release() { method.release(); }
    } at_the_end{*this};
    const double prepared = prepare(points, progress);
    std::vector<char> outside(static_cast<std::size_t>(count), 0), lost = outside;
    // About a tenth of a second passes between ticks. The weights do not depend on where the ticks are.
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
            for (int i = from; i < to; ++i)
                if (!all_finite(rows.row(i - from))) {
                    lost[static_cast<std::size_t>(first + i)] = 1;
                    rows.row(i - from).setZero();
                }
            weights.set_rows(first + from, rows);
            std::copy(out.begin(), out.end(), outside.begin() + first + from);
        });
        weights.check_memory();
        first += some;
        if (std::chrono::duration<double>(Clock::now() - slab_begin).count() < 0.05)
            slab = std::min(2 * slab, 1 << 20);
    }

    std::vector<int> without;
    for (int i = 0; i < count; ++i) {
        if (outside[static_cast<std::size_t>(i)])
            report.outside.push_back(i);
        if (lost[static_cast<std::size_t>(i)])
            without.push_back(i);
    }
    if (!without.empty())
        throw InvalidConstraint("points " + list_some(without) + " have no finite weights: the " +
                                    control_name() + " is too thin there",
                                Error::Element::vertex, without);
    if (!report.outside.empty() && !reaches_outside())
        throw PointsOutside("points " + list_some(report.outside) + " lie outside the " + control_name(),
                            Error::Element::vertex, report.outside);
    report.dropped = weights.dropped();
    report.weight_bytes = weights.bytes();
    finish(report);
    progress.tick(1.0, "computing weights");
    rest_controls_ = std::move(rest_controls);
    weights_ = std::move(weights);
}

void LinearSpaceMethod::displace(PointsView control, PointsView base, PositionsOut out) const
{
    check_control(control);
    Points moves;
    controls(control, moves);
    moves -= rest_controls_;
    std::visit([&](auto* positions) { weights_.apply(moves, base, positions); }, out);
}

std::vector<std::string> LinearSpaceMethod::changed_settings(const SpaceMethod& former) const
{
    const PointWeightOptions& other = static_cast<const LinearSpaceMethod&>(former).weight_options_;
    return names_of({{"precision", weight_options_.precision != other.precision},
                     {"threshold", weight_options_.threshold != other.threshold}});
}

void LinearSpaceMethod::swap_weights(SpaceMethod& other)
{
    auto& others = static_cast<LinearSpaceMethod&>(other);
    std::swap(weights_, others.weights_);
    std::swap(rest_controls_, others.rest_controls_);
}

} // namespace sinew
