// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/multigrid.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

using Node = HarmonicLattice::Node;
using Row = HarmonicMultigrid::Row;

constexpr int strip = HarmonicMultigrid::strip;
constexpr int coarsest = 4;        ///< fewest nodes along the longest side of the coarsest level
constexpr int last_sweeps = 24;    ///< number of sweeps on the coarsest level
constexpr double shortest = 1e-5;  ///< length of a link, in steps, to which shorter ones are raised
/// A cycle that begins with at most this residual is the last; it leaves a tenth of it.
constexpr double converged = 1e-4;
constexpr int whole = 96;          ///< most nodes along the longest side of a level without windows
constexpr int padding = 10; ///< distance from the faces to the sides of a window, in steps of the level
constexpr int most_cycles = 40;
constexpr int grain = 2048;

} // namespace

HarmonicMultigrid::HarmonicMultigrid(const HarmonicLattice& lattice, const Cage& cage,
                                     const std::vector<HarmonicData>& data)
{
    order(lattice, cage);
    const int longest = *std::ranges::max_element(lattice.size());
    while ((longest >> base_) > whole)
        ++base_;
    for (int level = 0; level == 0 || (longest >> level) >= coarsest; ++level) {
        levels_.emplace_back();
        number(lattice, level);
        if (level > base_ && levels_.back().count == 0) {
            levels_.pop_back();
            break;
        }
    }
    require_memory(bytes(), "the lattice in the cage");
    for (int level = 0; level < level_count(); ++level)
        link(lattice, data, level);
    for (int level = 0; level + 1 < level_count(); ++level)
        nest(level);
}

/// Orders the vertices so that those of a strip lie close together, by halving them along the longest side of
/// their box.
void HarmonicMultigrid::order(const HarmonicLattice& lattice, const Cage& cage)
{
    const int count = cage.control_count();
    std::vector<Vector3> at;
    for (int v = 0; v < count; ++v)
        at.push_back(lattice.coordinates(cage.control().row(v).transpose()));
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    const std::function<void(int, int)> split = [&](int begin, int end) {
        if (end - begin <= strip)
            return;
        Vector3 low = at[order_[begin]], high = low;
        for (int i = begin; i < end; ++i) {
            low = low.cwiseMin(at[order_[i]]);
            high = high.cwiseMax(at[order_[i]]);
        }
        int axis;
        (high - low).maxCoeff(&axis);
        std::sort(order_.begin() + begin, order_.begin() + end,
                  [&](int v, int w) { return std::pair(at[v][axis], v) < std::pair(at[w][axis], w); });
        const int middle = begin + ((end - begin) / 2 + strip - 1) / strip * strip;
        split(begin, middle);
        split(middle, end);
    };
    split(0, count);
    place_.resize(count);
    for (int i = 0; i < count; ++i)
        place_[order_[i]] = i;

    constexpr int far = std::numeric_limits<int>::max();
    stars_.assign((count + strip - 1) / strip, {{far, far, far}, {0, 0, 0}});
    const auto extend = [&](int control, std::span<const int> face) {
        Window& star = stars_[place_[control] / strip];
        for (int w : face) {
            const Vector3 corner = lattice.coordinates(cage.rest().point(w));
            for (int axis = 0; axis < 3; ++axis) {
                star.low[axis] = std::min(star.low[axis], static_cast<int>(std::floor(corner[axis])));
                star.high[axis] = std::max(star.high[axis], static_cast<int>(std::ceil(corner[axis])));
            }
        }
    };
    for (int f = 0; f < cage.rest().face_count(); ++f)
        for (int v : cage.rest().face(f)) {
            if (!cage.smooth())
                extend(v, cage.rest().face(f));
            else
                for (SparseRows::InnerIterator entry(cage.smooth()->matrix(), v); entry; ++entry)
                    extend(static_cast<int>(entry.col()), cage.rest().face(f));
        }
}

std::span<const int> HarmonicMultigrid::vertices(int strip_index) const
{
    const std::size_t first = static_cast<std::size_t>(strip_index) * strip;
    return {order_.data() + first, std::min<std::size_t>(strip, order_.size() - first)};
}

HarmonicMultigrid::Window HarmonicMultigrid::window(int strip_index, int level) const
{
    Window window = stars_[strip_index];
    for (int axis = 0; axis < 3; ++axis) {
        window.low[axis] -= padding << level;
        window.high[axis] += padding << level;
    }
    return window;
}

double HarmonicMultigrid::share(int strip_index, int level, const Vector3& at, double reach) const
{
    if (level >= base_)
        return 1.0;
    const Window own = window(strip_index, level);
    const double width = 0.5 * (padding << level);
    double least = 1.0;
    for (int axis = 0; axis < 3; ++axis)
        least = std::min(
            {least, (at[axis] - own.low[axis] - reach) / width, (own.high[axis] - at[axis] - reach) / width});
    return std::max(least, 0.0);
}

/// The lowest and the highest node of a window and `around` steps around it, in steps of a level.
std::array<Node, 2> HarmonicMultigrid::range(int level, const Window& window, int around) const
{
    std::array<Node, 2> range;
    for (int axis = 0; axis < 3; ++axis) {
        range[0][axis] = std::max(((window.low[axis] + (1 << level) - 1) >> level) - around, 0);
        range[1][axis] = std::min((window.high[axis] >> level) + around, levels_[level].size[axis] - 1);
    }
    return range;
}

HarmonicMultigrid::Work::Rows HarmonicMultigrid::rows(int level, const Window& window, int around) const
{
    const Level& own = levels_[level];
    const auto [low, high] = range(level, window, around);
    Work::Rows found;
    for (int i = low[0]; i <= high[0]; ++i)
        for (int j = low[1]; j <= high[1]; ++j) {
            const int* const line =
                own.rows.data() + (static_cast<std::size_t>(i) * own.size[1] + j) * own.size[2];
            for (int k = low[2]; k <= high[2]; ++k)
                if (line[k] >= 0)
                    (line[k] < own.reds ? found.reds : found.blacks).push_back(line[k]);
        }
    return found;
}

void HarmonicMultigrid::number(const HarmonicLattice& lattice, int level)
{
    Level& own = levels_[level];
    const int width = 1 << level;
    for (int axis = 0; axis < 3; ++axis)
        own.size[axis] = (lattice.size()[axis] - 1) / width + 1;
    constexpr int unused = -1, wanted = -2;
    own.rows.assign(static_cast<std::size_t>(own.size[0]) * own.size[1] * own.size[2],
                    level < base_ ? unused : wanted);
    for (int s = 0; s < strip_count() && level < base_; ++s) {
        const auto [low, high] = range(level, window(s, level), 3);
        for (int i = low[0]; i <= high[0]; ++i)
            for (int j = low[1]; j <= high[1]; ++j) {
                const auto line =
                    own.rows.begin() + (static_cast<std::ptrdiff_t>(i) * own.size[1] + j) * own.size[2];
                std::fill(line + low[2], line + high[2] + 1, wanted);
            }
    }
    for (int colour = 0; colour < 2; ++colour) {
        std::size_t at = 0;
        for (int i = 0; i < own.size[0]; ++i)
            for (int j = 0; j < own.size[1]; ++j)
                for (int k = 0; k < own.size[2]; ++k, ++at)
                    if (own.rows[at] == wanted && (i + j + k) % 2 == colour &&
                        lattice.inside({i * width, j * width, k * width}))
                        own.rows[at] = own.count++;
        if (colour == 0)
            own.reds = own.count;
    }
    std::ranges::replace(own.rows, wanted, unused);
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

/// Calls visit(row, node) for each row of a level, with the node in steps of that level.
template <class Visit>
void HarmonicMultigrid::each_row(const Level& level, Visit&& visit)
{
    std::size_t at = 0;
    for (int i = 0; i < level.size[0]; ++i)
        for (int j = 0; j < level.size[1]; ++j)
            for (int k = 0; k < level.size[2]; ++k, ++at)
                if (const int row = level.rows[at]; row >= 0)
                    visit(row, Node{i, j, k});
}

void HarmonicMultigrid::link(const HarmonicLattice& lattice, const std::vector<HarmonicData>& data, int level)
{
    Level& own = levels_[level];
    const int width = 1 << level;
    own.link.resize(own.count);
    own.share.resize(own.count);
    own.diagonal.resize(own.count);
    own.sources.resize(strip_count());
    each_row(own, [&](int row, const Node& steps) {
        const Node node{steps[0] * width, steps[1] * width, steps[2] * width};
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
                length[l] =
                    crossing[l] ? std::max(std::abs(crossing[l]->depth - node[axis]) / width, shortest) : 1.0;
            }
            for (int side = 0; side < 2; ++side) {
                const int l = 2 * axis + side;
                // A link that ends neither inside nor on the cage is due to rounding, and left out.
                const bool ends = crossing[l] || own.link[row][l] != own.count;
                share[l] = ends ? 2.0 / (length[l] * (length[l] + length[l ^ 1])) : 0.0;
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
                const int place = place_[vertex];
                own.sources[place / strip].push_back({row, place % strip, static_cast<float>(part * value)});
            });
        }
    });
}

/// Links a level to the next coarser one by the parents and children of nodes.
void HarmonicMultigrid::nest(int level)
{
    Level &own = levels_[level], &next = levels_[level + 1];
    const int width = 1 << level;
    own.parents.resize(own.count - own.reds);
    next.children.resize(next.count);
    each_row(own, [&](int row, const Node& steps) {
        if (row < own.reds)
            return;
        Parents& parents = own.parents[row - own.reds];
        const Node odd{steps[0] % 2, steps[1] % 2, steps[2] % 2};
        const bool one = odd[0] + odd[1] + odd[2] == 1;
        parents.count = one ? 2 : 8;
        parents.row.fill(next.count);
        for (int c = 0; c < parents.count; ++c) {
            Node parent = steps;
            for (int axis = 0; axis < 3; ++axis) {
                const int up = one ? c : c >> axis & 1;
                parent[axis] = (parent[axis] + odd[axis] * (2 * up - 1)) * width;
            }
            const int axis = odd[0] ? 0 : odd[1] ? 1 : 2;
            const bool cut = one && own.link[row][2 * axis + c] == own.count;
            if (const int found = cut ? -1 : this->row(level + 1, parent); found >= 0)
                parents.row[c] = found;
        }
    });
    each_row(next, [&](int row, const Node& steps) {
        const Node node{2 * steps[0] * width, 2 * steps[1] * width, 2 * steps[2] * width};
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
    });
}

std::int64_t HarmonicMultigrid::bytes() const
{
    constexpr std::int64_t a_node =
        12 * sizeof(int) + sizeof(float) + sizeof(Parents) / 2 + 13 * sizeof(int) / 8;
    std::int64_t bytes = 0;
    for (const Level& level : levels_)
        bytes += level.count * a_node + static_cast<std::int64_t>(level.rows.size() * sizeof(int));
    return bytes;
}

std::int64_t HarmonicMultigrid::work_bytes() const
{
    std::int64_t rows = 0;
    for (const Level& level : levels_)
        rows += 2 * level.count + level.reds + 2;
    return rows * static_cast<std::int64_t>(sizeof(Row));
}

/// The value that a node's neighbours and its source give for it.
HarmonicMultigrid::Row HarmonicMultigrid::wanted(int level, int row, const Work& work) const
{
    const Level& own = levels_[level];
    const Row* const values = work.values[level].data();
    Row sum = work.sources[level][row];
    for (int l = 0; l < 6; ++l) {
        const Row& other = values[own.link[row][l]];
        const float share = own.share[row][l];
        for (int k = 0; k < strip; ++k)
            sum.at[k] += share * other.at[k];
    }
    return sum;
}

/// One Gauss-Seidel sweep over nodes of one colour.
void HarmonicMultigrid::relax(int level, const std::vector<int>& rows, Work& work) const
{
    parallel_for(
        static_cast<int>(rows.size()),
        [&](int i) { work.values[level][rows[i]] = wanted(level, rows[i], work); }, grain);
}

/// Computes the residuals of the red nodes. Black ones have none, as they have just been relaxed.
double HarmonicMultigrid::find_residual(int level, Work& work) const
{
    const Level& own = levels_[level];
    const std::vector<int>& rows = work.solved[level].reds;
    const int count = static_cast<int>(rows.size());
    std::vector<float> largest((count + grain - 1) / grain, 0.0f);
    parallel_chunks(count, grain, [&](int begin, int end) {
        Row most{};
        for (int i = begin; i < end; ++i) {
            const int row = rows[i];
            const Row sum = wanted(level, row, work);
            const Row& value = work.values[level][row];
            Row& residual = work.residuals[level][row];
            for (int k = 0; k < strip; ++k) {
                const float gap = sum.at[k] - value.at[k];
                most.at[k] = std::max(most.at[k], std::abs(gap));
                residual.at[k] = own.diagonal[row] * gap;
            }
        }
        largest[begin / grain] = *std::max_element(most.at, most.at + strip);
    });
    return largest.empty() ? 0.0 : *std::ranges::max_element(largest);
}

/// Takes the values of the next coarser level to black nodes of a level, or adds them as corrections. A sweep
/// over the red nodes has to follow.
void HarmonicMultigrid::prolong(int level, const std::vector<int>& rows, Work& work, bool correct) const
{
    const Level& own = levels_[level];
    const int none = levels_[level + 1].count;
    Row* const values = work.values[level].data();
    const Row* const coarse = work.values[level + 1].data();
    parallel_for(
        static_cast<int>(rows.size()),
        [&](int i) {
            const Parents& parents = own.parents[rows[i] - own.reds];
            Row sum{};
            int count = correct ? parents.count : 0;
            for (int c = 0; c < parents.count; ++c) {
                count += !correct && parents.row[c] != none;
                for (int k = 0; k < strip; ++k)
                    sum.at[k] += coarse[parents.row[c]].at[k];
            }
            const float part = 1.0f / static_cast<float>(std::max(count, 1));
            Row& value = values[rows[i]];
            for (int k = 0; k < strip; ++k)
                value.at[k] = (correct ? value.at[k] : 0.0f) + part * sum.at[k];
        },
        grain);
}

/// A V-cycle; without correction by coarser levels, sweeps only, which never increase the residual.
/// \return the residual before the correction
double HarmonicMultigrid::cycle(int level, Work& work, bool correct) const
{
    const Work::Rows& own = work.solved[level];
    const bool last = !correct || level + 1 == level_count() || work.solved[level + 1].reds.empty();
    for (int sweep = 0; sweep < (last ? last_sweeps : 1); ++sweep) {
        relax(level, own.reds, work);
        relax(level, own.blacks, work);
    }
    const double residual = find_residual(level, work);
    if (last)
        return residual;
    const Level& next = levels_[level + 1];
    const Row* const residuals = work.residuals[level].data();
    Row* const sources = work.sources[level + 1].data();
    for (const std::vector<int>* rows : {&work.solved[level + 1].reds, &work.solved[level + 1].blacks})
        parallel_for(
            static_cast<int>(rows->size()),
            [&](int i) {
                const int row = (*rows)[i];
                const std::array<int, 13>& children = next.children[row];
                Row sum{};
                for (int c = 1; c < 13; ++c)
                    for (int k = 0; k < strip; ++k)
                        sum.at[k] += residuals[children[c]].at[k];
                // The restriction is full weighting; the factor includes the square of the ratio of the
                // steps.
                const float part = 0.5f / next.diagonal[row];
                for (int k = 0; k < strip; ++k)
                    sources[row].at[k] = part * (residuals[children[0]].at[k] + 0.25f * sum.at[k]);
            },
            grain);
    for (const std::vector<int>* rows : {&work.cleared[level + 1].reds, &work.cleared[level + 1].blacks})
        for (int row : *rows)
            work.values[level + 1][row] = {};
    cycle(level + 1, work, true);
    prolong(level, own.blacks, work, true);
    relax(level, own.reds, work);
    relax(level, own.blacks, work);
    return residual;
}

double HarmonicMultigrid::solve(int strip_index, Work& work, const std::function<void(int level)>& done) const
{
    if (work.values.empty()) {
        for (const Level& level : levels_) {
            work.values.emplace_back(level.count + 1, Row{});
            work.sources.emplace_back(level.count, Row{});
            work.residuals.emplace_back(level.reds + 1, Row{});
        }
        work.solved.resize(levels_.size());
        work.cleared.resize(levels_.size());
    }
    double left = 0.0;
    for (int level = level_count() - 1; level >= 0; --level) {
        const Window all{{0, 0, 0}, {1 << 30, 1 << 30, 1 << 30}};
        const Window own = level < base_ ? window(strip_index, level) : all;
        Window inner = own;
        // The correction of a coarser node needs residuals around it, so the windows shrink from level to
        // level.
        for (int k = level; k < level_count(); ++k) {
            work.solved[k] = rows(k, inner, 0);
            work.cleared[k] = rows(k, inner, 1);
            for (int axis = 0; axis < 3 && level < base_; ++axis) {
                inner.low[axis] += 1 << k;
                inner.high[axis] -= 1 << k;
            }
        }
        for (const std::vector<int>* rows : {&work.cleared[level].reds, &work.cleared[level].blacks})
            for (int row : *rows)
                work.sources[level][row] = work.values[level][row] = {};
        for (const Source& source : levels_[level].sources[strip_index])
            work.sources[level][source.row].at[source.lane] += source.value;
        if (level + 1 < level_count()) {
            prolong(level, rows(level, own, 2).blacks, work, false);
            relax(level, work.cleared[level].reds, work);
        }
        double residual = std::numeric_limits<double>::infinity();
        bool correct = true;
        for (int k = 0; k < most_cycles && residual > converged; ++k) {
            const double before = residual;
            residual = cycle(level, work, correct);
            correct = correct && residual < before;
        }
        left = std::max(left, residual);
        done(level);
    }
    return left;
}

} // namespace sinew
