// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/multigrid/hierarchy.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/space/space_order.h"
#include "native/solvers/sparse_columns.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace sinew {

namespace {

constexpr int most_on_coarsest = 3000;
constexpr double least_gain = 0.7;    ///< no further level that has more than this share of the nodes
constexpr double least_share = 0.01;  ///< smaller ones of a parent are dropped
constexpr double least_pull = 1e-9;   ///< as a share of the diagonal; less is rounding
constexpr double wide =
    0.1; ///< what a triangle loses for each time that its circumcircle has the radius of the nearest cell's distance
constexpr double flattest = 1e-6; ///< of the squared area of a triangle of cells to that of its edges

std::vector<int> in_space(const Points& points, const std::vector<int>& nodes)
{
    Points own(static_cast<Eigen::Index>(nodes.size()), 3);
    for (std::size_t k = 0; k < nodes.size(); ++k)
        own.row(static_cast<Eigen::Index>(k)) = points.row(nodes[k]);
    std::vector<int> order = space_order(view(own));
    for (int& place : order)
        place = nodes[place];
    return order;
}

/// Fills what follows from the links, pulls and masses.
void complete(Level& level, int order, double membrane)
{
    level.inverse_mass.resize(level.nodes);
    parallel_for(level.nodes,
                 [&](int i) { level.inverse_mass[i] = static_cast<float>(1.0 / level.mass[i]); });
    level.inverse_of_L.resize(level.free);
    level.inverse_diagonal.resize(level.free);
    parallel_for(level.free, [&](int i) {
        double sum = 0.0, squares = 0.0;
        for (int at = level.link_begin[i]; at < level.link_begin[i + 1]; ++at) {
            const auto [j, w] = level.links[at];
            sum += w;
            squares += static_cast<double>(w) * w * level.inverse_mass[j];
        }
        const double diagonal =
            (order == 1 ? sum : sum * sum * level.inverse_mass[i] + squares + membrane * sum) + level.pull[i];
        const auto inverse = [](double x) { return x > 1e-30 ? static_cast<float>(1.0 / x) : 0.0F; };
        level.inverse_of_L[i] = inverse(sum);
        level.inverse_diagonal[i] = inverse(diagonal);
    });
}

/// \param weight, mass, scale  the units of the level.
Level finest(const LinearSystem& system, double weight, double mass, double scale, std::vector<int>& unknowns,
             std::vector<int>& held)
{
    const SparseMatrix& L = system.graph;
    const int n = static_cast<int>(L.cols());
    std::vector<int> unknown_of(n, -1);
    for (int u = 0; u < static_cast<int>(system.vertices.size()); ++u)
        unknown_of[system.vertices[u]] = u;
    const auto is_free = [&](Eigen::Index v) { return unknown_of[v] >= 0; };
    std::vector<int> beside_free;
    for (int v = 0; v < n; ++v) {
        bool beside = false;
        if (!is_free(v))
            for (SparseMatrix::InnerIterator it(L, v); it && !beside; ++it)
                beside = is_free(it.row());
        if (beside)
            beside_free.push_back(v);
    }
    std::vector<int> order = in_space(system.points, system.vertices);
    held = in_space(system.points, beside_free);
    Level level;
    level.free = static_cast<int>(order.size());
    order.insert(order.end(), held.begin(), held.end());
    level.nodes = static_cast<int>(order.size());
    unknowns.resize(level.free);
    std::vector<int> name(n, -1);
    for (int k = 0; k < level.nodes; ++k)
        name[order[k]] = k;
    for (int k = 0; k < level.free; ++k)
        unknowns[k] = unknown_of[order[k]];

    const double size = (system.points.colwise().maxCoeff() - system.points.colwise().minCoeff()).norm();
    const double unit = size > 0 ? 1.0 / size : 1.0;
    level.points.resize(level.nodes, 3);
    level.mass.resize(level.nodes);
    level.link_begin.assign(level.nodes + 1, 0);
    const auto is_link = [&](int k, const SparseMatrix::InnerIterator& it) {
        const int other = name[it.row()];
        return other >= 0 && other != k && it.value() != 0.0;
    };
    parallel_for(level.nodes, [&](int k) {
        const int v = order[k];
        level.points.row(k) = unit * system.points.row(v);
        level.mass[k] = system.mass.size() > 0 ? system.mass[v] / mass : 1.0;
        for (SparseMatrix::InnerIterator it(L, v); it; ++it)
            level.link_begin[k + 1] += is_link(k, it);
    });
    std::partial_sum(level.link_begin.begin(), level.link_begin.end(), level.link_begin.begin());
    level.links.resize(level.link_begin.back());
    const bool exact = system.matrix.cols() == 0;
    level.rounding.resize(exact ? level.links.size() : 0);
    level.pull.resize(level.free);
    parallel_for(level.nodes, [&](int k) {
        Level::Link* const begin = level.links.data() + level.link_begin[k];
        Level::Link* end = begin;
        double sum = 0.0, diagonal = 0.0;
        for (SparseMatrix::InnerIterator it(L, order[k]); it; ++it) {
            sum += it.value();
            if (it.row() == order[k])
                diagonal = it.value();
            else if (is_link(k, it))
                *end++ = {name[it.row()], static_cast<float>(-it.value() / weight)};
        }
        std::sort(begin, end, [](const Level::Link& a, const Level::Link& b) { return a.node < b.node; });
        for (const Level::Link* link = begin; exact && link < end; ++link)
            level.rounding[link - level.links.data()] =
                static_cast<float>(-L.coeff(order[link->node], order[k]) / weight - link->weight);
        if (k < level.free && exact)
            level.pull[k] = static_cast<float>(scale * system.pulls[unknowns[k]]);
        else if (k < level.free)
            level.pull[k] =
                sum > least_pull * diagonal && system.order == 1 ? static_cast<float>(sum / weight) : 0.0F;
    });
    return level;
}

/// What the diagonal of A has beyond that of L (M^-1 L + membrane).
void find_pulls(const LinearSystem& system, const Hierarchy& hierarchy, Level& level)
{
    constexpr double rounding = 1e-5; // of weights in single precision
    const VectorX diagonal = system.matrix.diagonal();
    for (int i = 0; i < level.free; ++i) {
        const double all = hierarchy.scale * diagonal[hierarchy.unknowns[i]],
                     known = 1.0 / level.inverse_diagonal[i];
        level.pull[i] = all - known > rounding * all ? static_cast<float>(all - known) : 0.0F;
    }
}

/// Nodes of a level grouped around seeds.
struct Cells
{
    int free = 0, count = 0;
    std::vector<int> of; ///< (nodes)
    std::vector<int> begin, members; ///< of each cell
    std::vector<int> touch_begin, touching; ///< the other cells beside each one, rising
    Points centres;

    Cells(const Level& level, int rings) : of(level.nodes, -1)
    {
        gather(level, rings);
        begin.assign(count + 1, 0);
        for (const int c : of)
            ++begin[c + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        members.resize(level.nodes);
        std::vector<int> next(begin.begin(), begin.end() - 1);
        for (int i = 0; i < level.nodes; ++i)
            members[next[of[i]]++] = i;
        find_touching(level);
        centres.resize(count, 3);
        parallel_for(count, [&](int c) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (int at = begin[c]; at < begin[c + 1]; ++at)
                sum += level.points.row(members[at]);
            centres.row(c) = sum / (begin[c + 1] - begin[c]);
        });
    }

    bool touch(int c, int other) const
    {
        return std::binary_search(touching.begin() + touch_begin[c], touching.begin() + touch_begin[c + 1],
                                  other);
    }

private:
    /// Seeds in the order of the nodes. Each node is in the cell of the nearest seed of its own kind, free or held,
    /// that is at most so many rings away.
    void gather(const Level& level, int rings)
    {
        std::vector<double> distance(level.nodes, std::numeric_limits<double>::infinity());
        std::vector<int> ball, seen_by(level.nodes, -1);
        for (int seed = 0; seed < level.nodes; ++seed) {
            if (seed == level.free)
                free = count;
            if (of[seed] >= 0)
                continue;
            const bool is_free = seed < level.free;
            ball.assign(1, seed);
            seen_by[seed] = seed;
            std::size_t at = 0;
            for (int ring = 0; ring <= rings; ++ring)
                for (const std::size_t end = ball.size(); at < end; ++at) {
                    const int i = ball[at];
                    const double d = (level.points.row(i) - level.points.row(seed)).squaredNorm();
                    if (d < distance[i]) {
                        distance[i] = d;
                        of[i] = count;
                    }
                    for (int k = level.link_begin[i]; ring < rings && k < level.link_begin[i + 1]; ++k)
                        if (const int j = level.links[k].node;
                            seen_by[j] != seed && (j < level.free) == is_free) {
                            seen_by[j] = seed;
                            ball.push_back(j);
                        }
                }
            ++count;
        }
        if (level.free == level.nodes)
            free = count;
    }

    void find_touching(const Level& level)
    {
        std::vector<int> seen_by(count, -1);
        touch_begin.assign(1, 0);
        for (int c = 0; c < count; ++c) {
            seen_by[c] = c;
            for (int at = begin[c]; at < begin[c + 1]; ++at)
                for (int k = level.link_begin[members[at]]; k < level.link_begin[members[at] + 1]; ++k)
                    if (const int other = of[level.links[k].node]; seen_by[other] != c) {
                        seen_by[other] = c;
                        touching.push_back(other);
                    }
            std::sort(touching.begin() + touch_begin.back(), touching.end());
            touch_begin.push_back(static_cast<int>(touching.size()));
        }
    }
};

/// A triangle of the centre of a cell and those of two beside it.
struct CellTriangle
{
    int first, second;
    Eigen::RowVector3d to_first, to_second;
    double radius; ///< of the circle through the three
    double a, b, c; ///< the inverse of the Gram matrix of the two sides

    std::array<double, 2> place(const Eigen::RowVector3d& v) const
    {
        const double x = v.dot(to_first), y = v.dot(to_second);
        return {a * x + b * y, b * x + c * y};
    }
};

std::vector<CellTriangle> triangles_of(const Cells& cells, int cell)
{
    std::vector<CellTriangle> found;
    const int *begin = cells.touching.data() + cells.touch_begin[cell],
              *end = cells.touching.data() + cells.touch_begin[cell + 1];
    for (const int* p = begin; p < end; ++p)
        for (const int* q = p + 1; q < end; ++q) {
            if (!cells.touch(*p, *q))
                continue;
            const Eigen::RowVector3d e = cells.centres.row(*p) - cells.centres.row(cell),
                                     f = cells.centres.row(*q) - cells.centres.row(cell);
            const double ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm(), det = ee * ff - ef * ef;
            if (det > flattest * ee * ff)
                found.push_back({*p, *q, e, f, std::sqrt(ee * ff * (e - f).squaredNorm() / det) / 2, ff / det,
                                 -ef / det, ee / det});
        }
    return found;
}

/// Chooses the parents of all nodes: the corners of the triangle in which, or nearest to which, the node is.
void interpolate(Level& level, const Cells& cells)
{
    level.parents.resize(level.nodes);
    level.shares.resize(level.nodes);
    parallel_for(
        cells.count,
        [&](int c) {
            const std::vector<CellTriangle> triangles =
                c < cells.free ? triangles_of(cells, c) : std::vector<CellTriangle>{};
            double nearest = std::numeric_limits<double>::infinity();
            for (const CellTriangle& t : triangles)
                nearest = std::min({nearest, t.to_first.norm(), t.to_second.norm()});
            for (int at = cells.begin[c]; at < cells.begin[c + 1]; ++at) {
                const int i = cells.members[at];
                const Eigen::RowVector3d v = level.points.row(i) - cells.centres.row(c);
                const CellTriangle* best = nullptr;
                double highest = -std::numeric_limits<double>::infinity();
                for (const CellTriangle& t : triangles) {
                    const auto [x, y] = t.place(v);
                    const double beside = (v - x * t.to_first - y * t.to_second).norm() /
                                          (t.to_first.norm() + t.to_second.norm());
                    const double inside =
                        std::min({x, y, 1 - x - y, 0.0}) - beside - wide * t.radius / nearest;
                    if (inside > highest) {
                        highest = inside;
                        best = &t;
                    }
                }
                level.parents[i] = {c, c, c};
                level.shares[i] = {1, 0, 0};
                if (!best)
                    continue;
                const auto [x, y] = best->place(v);
                std::array<double, 3> shares{1 - x - y, x, y};
                double sum = 0.0;
                for (double& share : shares)
                    sum += share = share > least_share ? share : 0.0;
                level.parents[i] = {c, best->first, best->second};
                for (int k = 0; k < 3; ++k)
                    level.shares[i][k] = static_cast<float>(shares[k] / sum);
            }
        },
        64);
    level.child_begin.assign(cells.count + 1, 0);
    const auto for_each = [&](auto&& body) {
        for (int i = 0; i < level.nodes; ++i)
            for (int k = 0; k < 3; ++k)
                if (level.shares[i][k] > 0)
                    body(level.parents[i][k], i, level.shares[i][k]);
    };
    for_each([&](int parent, int, float) { ++level.child_begin[parent + 1]; });
    std::partial_sum(level.child_begin.begin(), level.child_begin.end(), level.child_begin.begin());
    level.children.resize(level.child_begin.back());
    std::vector<int> next(level.child_begin.begin(), level.child_begin.end() - 1);
    for_each([&](int parent, int i, float share) { level.children[next[parent]++] = {i, share}; });
}

/// The next level, whose L and M are those of this one between functions that follow the parents.
Level coarser(Level& level, int order)
{
    const Cells cells(level, order == 1 ? 2 : 1);
    interpolate(level, cells);
    Level coarse;
    coarse.free = cells.free;
    coarse.nodes = cells.count;
    coarse.points = cells.centres;
    coarse.mass.resize(coarse.nodes);
    parallel_for(coarse.nodes, [&](int c) {
        double sum = 0.0;
        for (int at = level.child_begin[c]; at < level.child_begin[c + 1]; ++at)
            sum += static_cast<double>(level.children[at].weight) * level.mass[level.children[at].node];
        coarse.mass[c] = sum > 0 ? sum : 1.0; // of a cell that no node follows
    });
    const SparseMatrix product =
        sparse_by_columns(coarse.nodes, coarse.nodes, [&](int c, SparseColumn& column) {
            const auto add = [&](int node, double value) {
                for (int k = 0; k < 3; ++k)
                    if (level.shares[node][k] > 0)
                        column.add(level.parents[node][k], value * level.shares[node][k]);
            };
            column.add(c, 0.0);
            for (int at = level.child_begin[c]; at < level.child_begin[c + 1]; ++at) {
                const auto [i, share] = level.children[at];
                double sum = order == 1 && i < level.free ? level.pull[i] : 0.0;
                for (int k = level.link_begin[i]; k < level.link_begin[i + 1]; ++k) {
                    const auto [j, w] = level.links[k];
                    sum += w;
                    add(j, -static_cast<double>(share) * w);
                }
                add(i, share * sum);
            }
        });
    coarse.pull.assign(coarse.free, 0.0F);
    coarse.link_begin.assign(1, 0);
    coarse.links.reserve(product.nonZeros());
    for (int c = 0; c < coarse.nodes; ++c) {
        double sum = 0.0, diagonal = 0.0;
        for (SparseMatrix::InnerIterator it(product, c); it; ++it) {
            const int other = static_cast<int>(it.row());
            sum += it.value();
            if (other == c)
                diagonal = it.value();
            else
                coarse.links.push_back({other, static_cast<float>(-it.value())});
        }
        if (order == 1 && c < coarse.free && sum > least_pull * diagonal)
            coarse.pull[c] = static_cast<float>(sum);
        for (int at = level.child_begin[c]; order == 2 && c < coarse.free && at < level.child_begin[c + 1];
             ++at)
            coarse.pull[c] += level.children[at].weight * level.pull[level.children[at].node];
        coarse.link_begin.push_back(static_cast<int>(coarse.links.size()));
    }
    return coarse;
}

template <class T>
std::int64_t size_of(const std::vector<T>& values)
{
    return static_cast<std::int64_t>(values.size() * sizeof(T));
}

} // namespace

std::int64_t Level::bytes() const
{
    return size_of(link_begin) + size_of(links) + size_of(rounding) + size_of(pull) + size_of(inverse_mass) +
           size_of(inverse_of_L) + size_of(inverse_diagonal) + size_of(parents) + size_of(shares) +
           size_of(child_begin) + size_of(children) +
           static_cast<std::int64_t>(sizeof(double)) * (points.size() + mass.size());
}

std::int64_t Hierarchy::bytes() const
{
    std::int64_t sum = size_of(unknowns);
    for (const Level& level : levels)
        sum += level.bytes();
    return sum;
}

Hierarchy::Hierarchy(const LinearSystem& system, const Progress& progress) : order(system.order)
{
    if (!system.has_nodes())
        throw InvalidOption("multigrid needs the points and the graph of the system; choose another solver");
    if (order > 2)
        throw InvalidOption("multigrid is for systems of order 1 and 2, not of order " +
                            std::to_string(order));
    const double diagonal = system.graph.diagonal().mean();
    weight = diagonal > 0 ? diagonal : 1.0;
    double mass = 0.0;
    for (Eigen::Index i = 0; i < system.mass.size(); ++i)
        mass +=
            std::isfinite(system.mass[i]) ? system.mass[i] / static_cast<double>(system.mass.size()) : 0.0;
    mass = mass > 0 ? mass : 1.0;
    scale = order == 1 ? 1.0 / weight : mass / weight / weight;
    membrane = system.membrane * mass / weight;
    levels.push_back(finest(system, weight, mass, scale, unknowns, held));
    complete(levels.back(), order, membrane);
    if (order == 2 && system.matrix.cols() > 0) {
        find_pulls(system, *this, levels.back());
        complete(levels.back(), order, membrane);
    }
    for (;;) {
        const Level& last = levels.back();
        progress.tick(0.0, "building the hierarchy");
        const bool enough = levels.size() > 1 && last.free > least_gain * levels[levels.size() - 2].free;
        if (last.free <= most_on_coarsest || enough)
            break;
        Level next = coarser(levels.back(), order);
        complete(next, order, membrane);
        levels.back().points.resize(0, 3);
        levels.back().mass.resize(0);
        levels.push_back(std::move(next));
    }
}

} // namespace sinew
