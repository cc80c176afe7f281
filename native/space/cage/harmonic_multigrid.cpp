// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/harmonic_multigrid.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstdio>

namespace sinew {

namespace {

using Node = HarmonicLattice::Node;
using Row = HarmonicMultigrid::Row;

constexpr int strip = HarmonicMultigrid::strip;
constexpr int coarsest = 4;        ///< nodes along the longest side where halving ends
constexpr int last_sweeps = 24;    ///< on the coarsest level
constexpr double shortest = 1e-5;  ///< of a link, in steps
constexpr float converged = 1e-5f; ///< residual where cycles end
constexpr int most_cycles = 40;
constexpr int grain = 2048;

void clear(std::vector<Row>& rows) { std::ranges::fill(rows, Row{}); }

} // namespace

HarmonicMultigrid::HarmonicMultigrid(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data,
                                     int columns)
{
    const int longest = *std::ranges::max_element(lattice.size());
    const int strips = (columns + strip - 1) / strip;
    for (int level = 0; level == 0 || (longest >> level) >= coarsest; ++level) {
        levels_.emplace_back();
        number(lattice, level);
        if (level > 0 && levels_.back().count == 0) {
            levels_.pop_back();
            break;
        }
        link(lattice, data, level, strips);
    }
    for (int level = 0; level + 1 < level_count(); ++level)
        nest(level);
}

void HarmonicMultigrid::number(const HarmonicLattice& lattice, int level)
{
    Level& own = levels_[level];
    const int width = 1 << level;
    for (int axis = 0; axis < 3; ++axis)
        own.size[axis] = (lattice.size()[axis] - 1) / width + 1;
    own.rows.assign(static_cast<std::size_t>(own.size[0]) * own.size[1] * own.size[2], -1);
    for (int colour = 0; colour < 2; ++colour) {
        std::size_t at = 0;
        for (int i = 0; i < own.size[0]; ++i)
            for (int j = 0; j < own.size[1]; ++j)
                for (int k = 0; k < own.size[2]; ++k, ++at)
                    if ((i + j + k) % 2 == colour && lattice.inside({i * width, j * width, k * width}))
                        own.rows[at] = own.count++;
        if (colour == 0)
            own.reds = own.count;
    }
}

int HarmonicMultigrid::row(int level, const Node& node) const
{
    const Level& own = levels_[level];
    std::size_t at = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int k = node[axis] >> level;
        if (k < 0 || k >= own.size[axis])
            return -1;
        at = at * own.size[axis] + k;
    }
    return own.rows[at];
}

void HarmonicMultigrid::link(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data, int level,
                             int strips)
{
    static const bool symmetric = std::getenv("SYM") != nullptr;
    Level& own = levels_[level];
    const int width = 1 << level;
    own.link.resize(own.count);
    own.share.resize(own.count);
    own.diagonal.resize(own.count);
    own.sources.resize(strips);
    std::size_t at = 0;
    for (int i = 0; i < own.size[0]; ++i)
        for (int j = 0; j < own.size[1]; ++j)
            for (int k = 0; k < own.size[2]; ++k, ++at) {
                const int row = own.rows[at];
                if (row < 0)
                    continue;
                const Node node{i * width, j * width, k * width};
                std::array<const HarmonicLattice::Crossing*, 6> crossing;
                std::array<double, 6> length, share;
                double sum = 0.0;
                for (int axis = 0; axis < 3; ++axis) {
                    for (int side = 0; side < 2; ++side) {
                        const int l = 2 * axis + side, sign = side ? 1 : -1;
                        Node other = node;
                        other[axis] += sign * width;
                        crossing[l] = lattice.next(node, axis, sign, width);
                        const int neighbour = crossing[l] ? -1 : this->row(level, other);
                        own.link[row][l] = neighbour < 0 ? own.count : neighbour;
                        length[l] = crossing[l] ? std::max(std::abs(crossing[l]->depth - node[axis]) / width,
                                                           shortest)
                                                : 1.0;
                    }
                    for (int side = 0; side < 2; ++side) {
                        const int l = 2 * axis + side;
                        // A link that ends neither inside nor on the cage is left out: rounding made it.
                        const bool ends = crossing[l] || own.link[row][l] != own.count;
                        share[l] = ends ? 2.0 / (length[l] * (length[l] + length[l ^ 1])) : 0.0;
                        if (symmetric && ends)
                            share[l] = 1.0 / length[l];
                        sum += share[l];
                    }
                }
                own.diagonal[row] = static_cast<float>(sum);
                for (int l = 0; l < 6; ++l) {
                    const double part = sum > 0.0 ? share[l] / sum : 0.0;
                    own.share[row][l] = static_cast<float>(part);
                    if (!crossing[l])
                        continue;
                    data[crossing[l]->triangle].each(crossing[l]->hats, [&](int vertex, double value) {
                        own.sources[vertex / strip].push_back(
                            {row, vertex % strip, static_cast<float>(part * value)});
                    });
                }
            }
}

/// What a level has to do with the next.
void HarmonicMultigrid::nest(int level)
{
    Level &own = levels_[level], &next = levels_[level + 1];
    const int width = 1 << level;
    own.parents.resize(own.count - own.reds);
    next.children.resize(next.count);
    std::size_t at = 0;
    for (int i = 0; i < own.size[0]; ++i)
        for (int j = 0; j < own.size[1]; ++j)
            for (int k = 0; k < own.size[2]; ++k, ++at) {
                const int row = own.rows[at];
                if (row < own.reds)
                    continue;
                Parents& parents = own.parents[row - own.reds];
                const Node odd{i % 2, j % 2, k % 2};
                const bool one = odd[0] + odd[1] + odd[2] == 1;
                parents.count = one ? 2 : 8;
                parents.row.fill(next.count);
                for (int c = 0; c < parents.count; ++c) {
                    Node parent{i, j, k};
                    for (int axis = 0; axis < 3; ++axis) {
                        const int up = one ? c : c >> axis & 1;
                        parent[axis] = (parent[axis] + odd[axis] * (2 * up - 1)) * width;
                    }
                    const int axis = odd[0] ? 0 : odd[1] ? 1 : 2;
                    const bool cut = one && own.link[row][2 * axis + c] == own.count;
                    if (const int found = cut ? -1 : this->row(level + 1, parent); found >= 0)
                        parents.row[c] = found;
                }
            }
    at = 0;
    for (int i = 0; i < next.size[0]; ++i)
        for (int j = 0; j < next.size[1]; ++j)
            for (int k = 0; k < next.size[2]; ++k, ++at) {
                const int row = next.rows[at];
                if (row < 0)
                    continue;
                const Node node{2 * i * width, 2 * j * width, 2 * k * width};
                std::array<int, 13>& children = next.children[row];
                children.fill(own.reds);
                children[0] = this->row(level, node);
                int c = 1;
                for (int axis = 0; axis < 3; ++axis)
                    for (int corner = 0; corner < 4; ++corner, ++c) {
                        Node child = node;
                        child[(axis + 1) % 3] += corner & 1 ? width : -width;
                        child[(axis + 2) % 3] += corner & 2 ? width : -width;
                        if (const int found = this->row(level, child); found >= 0)
                            children[c] = found;
                    }
            }
}

std::int64_t HarmonicMultigrid::work_bytes() const
{
    std::int64_t rows = 0;
    for (const Level& level : levels_)
        rows += 2 * level.count + level.reds + 2;
    return rows * static_cast<std::int64_t>(sizeof(Row));
}

/// Each value becomes what its neighbours and its source say.
void HarmonicMultigrid::relax(int level, int begin, int end, Work& work) const
{
    const Level& own = levels_[level];
    Row* const values = work.values[level].data();
    const Row* const sources = work.sources[level].data();
    parallel_for(
        end - begin,
        [&](int i) {
            const int row = begin + i;
            Row sum = sources[row];
            for (int l = 0; l < 6; ++l) {
                const Row& other = values[own.link[row][l]];
                const float share = own.share[row][l];
                for (int k = 0; k < strip; ++k)
                    sum.at[k] += share * other.at[k];
            }
            values[row] = sum;
        },
        grain);
}

/// At the reds, after the blacks have been relaxed: these have none.
double HarmonicMultigrid::find_residual(int level, Work& work) const
{
    const Level& own = levels_[level];
    const Row* const values = work.values[level].data();
    const Row* const sources = work.sources[level].data();
    Row* const residuals = work.residuals[level].data();
    std::vector<float> largest((own.reds + grain - 1) / grain, 0.0f);
    parallel_chunks(own.reds, grain, [&](int begin, int end) {
        Row most{};
        for (int row = begin; row < end; ++row) {
            Row sum = sources[row];
            for (int l = 0; l < 6; ++l) {
                const Row& other = values[own.link[row][l]];
                const float share = own.share[row][l];
                for (int k = 0; k < strip; ++k)
                    sum.at[k] += share * other.at[k];
            }
            const float diagonal = own.diagonal[row];
            for (int k = 0; k < strip; ++k) {
                const float gap = sum.at[k] - values[row].at[k];
                most.at[k] = std::max(most.at[k], std::abs(gap));
                residuals[row].at[k] = diagonal * gap;
            }
        }
        largest[begin / grain] = *std::max_element(most.at, most.at + strip);
    });
    return largest.empty() ? 0.0 : *std::ranges::max_element(largest);
}

/// To the blacks of a level from the next: its values, or what they correct. The reds follow in a sweep.
void HarmonicMultigrid::prolong(int level, Work& work, bool correct) const
{
    const Level& own = levels_[level];
    const int none = levels_[level + 1].count;
    Row* const values = work.values[level].data() + own.reds;
    const Row* const coarse = work.values[level + 1].data();
    parallel_for(
        own.count - own.reds,
        [&](int i) {
            const Parents& parents = own.parents[i];
            Row sum{};
            int count = correct ? parents.count : 0;
            for (int c = 0; c < parents.count; ++c) {
                count += !correct && parents.row[c] != none;
                for (int k = 0; k < strip; ++k)
                    sum.at[k] += coarse[parents.row[c]].at[k];
            }
            const float part = 1.0f / static_cast<float>(std::max(count, 1));
            for (int k = 0; k < strip; ++k)
                values[i].at[k] = (correct ? values[i].at[k] : 0.0f) + part * sum.at[k];
        },
        grain);
}

void HarmonicMultigrid::cycle(int level, Work& work, double* residual) const
{
    const Level& own = levels_[level];
    const bool last = level + 1 == level_count();
    for (int sweep = 0; sweep < (last ? last_sweeps : 1); ++sweep) {
        relax(level, 0, own.reds, work);
        relax(level, own.reds, own.count, work);
    }
    if (last && !residual)
        return;
    const double most = find_residual(level, work);
    if (residual)
        *residual = most;
    if (last)
        return;
    const Level& next = levels_[level + 1];
    const Row* const residuals = work.residuals[level].data();
    Row* const sources = work.sources[level + 1].data();
    parallel_for(
        next.count,
        [&](int i) {
            const std::array<int, 13>& children = next.children[i];
            Row sum{};
            for (int c = 1; c < 13; ++c)
                for (int k = 0; k < strip; ++k)
                    sum.at[k] += residuals[children[c]].at[k];
            // Full weighting, and the square of the levels' steps.
            const float part = 0.5f / next.diagonal[i];
            for (int k = 0; k < strip; ++k)
                sources[i].at[k] = part * (residuals[children[0]].at[k] + 0.25f * sum.at[k]);
        },
        grain);
    clear(work.values[level + 1]);
    cycle(level + 1, work, nullptr);
    prolong(level, work, true);
    relax(level, 0, own.reds, work);
    relax(level, own.reds, own.count, work);
}

double HarmonicMultigrid::solve(int first_column, Work& work, const std::function<void(int level)>& done) const
{
    if (work.values.empty())
        for (const Level& level : levels_) {
            work.values.emplace_back(level.count + 1, Row{});
            work.sources.emplace_back(level.count, Row{});
            work.residuals.emplace_back(level.reds + 1, Row{});
        }
    static const bool talk = std::getenv("TALK") != nullptr;
    double residual = 0.0;
    for (int level = level_count() - 1; level >= 0; --level) {
        if (level + 1 < level_count())
            prolong(level, work, false);
        else
            clear(work.values[level]);
        clear(work.sources[level]);
        for (const Source& source : levels_[level].sources[first_column / strip])
            work.sources[level][source.row].at[source.lane] += source.value;
        double before = 1.0;
        for (int k = 0; k < most_cycles; ++k) {
            cycle(level, work, &residual);
            if (talk)
                std::fprintf(stderr, "level %d (%d) cycle %d: %.2e\n", level, levels_[level].count, k, residual);
            if (residual < converged)
                break;
            before = residual;
        }
        done(level);
    }
    return residual;
}

} // namespace sinew
