// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_system.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/space/space_order.h"
#include "native/local_global/graph/graph_iteration.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

double sum_of_squares(const GraphEdges& edges, const GraphCells& cells, const PointsView& base)
{
    return parallel_sum(edges.size(), [&](int i) {
        double sum = 0.0;
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            sum += edges.weights[a] * (base.row(i) - base.row(edges.neighbours[a])).squaredNorm();
        return cells.rigidity[i] * sum;
    });
}

} // namespace

std::vector<double> GraphCells::laplacian(const GraphEdges& edges) const
{
    std::vector<double> entries(edges.weights.size(), 0.0);
    if (!rims) {
        for (int i = 0; i < edges.size(); ++i)
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
                entries[a] = edges.weights[a] * edge_rigidity(i, edges.neighbours[a]);
        return entries;
    }
    const auto add = [&](int i, int j, double value) {
        const auto first = edges.neighbours.begin() + edges.offsets[i];
        const auto last = edges.neighbours.begin() + edges.offsets[i + 1];
        if (i != j) // a face may name a vertex twice
            entries[std::lower_bound(first, last, j) - edges.neighbours.begin()] += value;
    };
    for (const GraphTriangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const int i = t.corner[(k + 1) % 3], j = t.corner[(k + 2) % 3];
            const double mean = (rigidity[i] + rigidity[j] + rigidity[t.corner[k]]) / 3.0;
            add(i, j, mean * t.across[k]);
            add(j, i, mean * t.across[k]);
        }
    return entries;
}

std::vector<double> GraphCells::moments(const GraphEdges& edges, const Points& rest) const
{
    std::vector<double> moment(edges.size(), 0.0);
    const auto square = [&](int i, int j) { return (rest.row(i) - rest.row(j)).squaredNorm(); };
    for (int i = 0; !rims && i < edges.size(); ++i)
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            moment[i] += 2.0 / 3.0 * rigidity[i] * edges.weights[a] * square(i, edges.neighbours[a]);
    for (const GraphTriangle& t : triangles) {
        double spread = 0.0;
        for (int k = 0; k < 3; ++k)
            spread += t.across[k] * square(t.corner[(k + 1) % 3], t.corner[(k + 2) % 3]);
        for (int i : t.corner)
            moment[i] += 2.0 / 3.0 * rigidity[i] * spread;
    }
    // A node without edges, or in a part that has shrunk to a point, needs a positive pivot, too.
    const double least = 1e-12 * std::max(1e-280, *std::ranges::max_element(moment));
    for (double& each : moment)
        each += least;
    return moment;
}

GraphChunks::GraphChunks(const GraphEdges& graph, const std::vector<GraphTriangle>& given, int moving_nodes,
                         int nodes)
{
    std::vector<int> chunk_of(graph.size(), -1);
    for (int begin = 0; begin < nodes;) {
        const int end = std::min(begin + graph_chunk, begin < moving_nodes ? moving_nodes : nodes);
        std::fill(chunk_of.begin() + begin, chunk_of.begin() + end, static_cast<int>(all.size()));
        all.push_back({begin, end, 0, 0});
        moving += begin < moving_nodes;
        begin = end;
    }

    edges.reserve(2 * static_cast<std::size_t>(graph.size()) + 1);
    for (int i = 0; i < graph.size(); ++i)
        for (bool within : {true, false}) {
            edges.push_back(static_cast<int>(ends.size()));
            for (int a = graph.offsets[i]; a < graph.offsets[i + 1]; ++a) {
                const int j = graph.neighbours[a];
                if ((chunk_of[i] == chunk_of[j]) == within && (!within || i < j)) {
                    ends.push_back(j);
                    weights.push_back(graph.weights[a]);
                }
            }
        }
    edges.push_back(static_cast<int>(ends.size()));

    std::vector<std::vector<int>> touching(all.size());
    for (int t = 0; t < static_cast<int>(given.size()); ++t)
        for (int corner : given[t].corner)
            if (const int chunk = chunk_of[corner];
                chunk >= 0 && (touching[chunk].empty() || touching[chunk].back() != t))
                touching[chunk].push_back(t);
    for (std::size_t c = 0; c < all.size(); ++c) {
        std::ranges::stable_sort(touching[c], {}, [&](int t) { return std::ranges::min(given[t].corner); });
        all[c].first_triangle = static_cast<int>(triangles.size());
        for (int t : touching[c])
            triangles.push_back(given[t]);
        all[c].last_triangle = static_cast<int>(triangles.size());
    }
}

/// The parts of a ArapSystem while they are made: factors in the numbers of the given graph, and the new
/// order.
struct ArapSystem::Parts
{
    const HandleGraph& given;
    GraphCells cells;
    SingleFactor position_factor, rotation_factor;
    double rest_scale;
    std::vector<int> order;
    int moving_nodes = 0, present_nodes = 0;

    Parts(const HandleGraph& graph, GraphCells own, const Points& rest, bool factorized)
        : given(graph), cells(std::move(own)), rest_scale(sum_of_squares(graph.edges(), cells, view(rest)))
    {
        if (factorized)
            factorize(rest);
        sort(rest);
        const std::vector<int> renamed = new_numbers(order);
        std::vector<int> free_renamed;
        // The free nodes come first in the new order, so their new numbers are also their places.
        for (int i : given.free_nodes())
            free_renamed.push_back(renamed[i]);
        position_factor.rename(free_renamed);
        rotation_factor.rename(renamed);
        std::vector<double> rigidity;
        for (int i : order)
            rigidity.push_back(cells.rigidity[i]);
        cells.rigidity = std::move(rigidity);
        for (GraphTriangle& t : cells.triangles)
            for (int& corner : t.corner)
                corner = renamed[corner];
    }

private:
    void factorize(const Points& rest)
    {
        const GraphEdges& edges = given.edges();
        const int size = given.size();
        const double smoothing = cells.smoothing;
        const std::vector<double> laplacian = cells.laplacian(edges);
        std::vector<Eigen::Triplet<double>> L, M;
        for (int i = 0; i < size; ++i)
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                const int j = edges.neighbours[a];
                if (given.place(i) >= 0) {
                    L.emplace_back(given.place(i), given.place(i), laplacian[a]);
                    if (given.place(j) >= 0)
                        L.emplace_back(given.place(i), given.place(j), -laplacian[a]);
                }
                if (smoothing > 0) {
                    M.emplace_back(i, j, -4 * smoothing * edges.weights[a] * cells.edge_rigidity(i, j));
                    M.emplace_back(i, i, 4 * smoothing * edges.weights[a] * cells.edge_rigidity(i, j));
                }
            }
        for (const GraphPull& pull : given.pulls())
            L.emplace_back(given.place(pull.node), given.place(pull.node), pull.stiffness);
        SparseMatrix matrix(given.free_count(), given.free_count());
        matrix.setFromTriplets(L.begin(), L.end());
        if (!(smoothing > 0)) {
            named([&] { position_factor.factorize(matrix); });
            return;
        }
        const std::vector<double> moment = cells.moments(edges, rest);
        for (int i = 0; i < size; ++i)
            M.emplace_back(i, i, moment[i]);
        SparseMatrix field(size, size);
        field.setFromTriplets(M.begin(), M.end());
        // An ordering of all nodes is also one of the free nodes, if the others are left out.
        const std::vector<int> elimination = fill_reducing_order(field);
        rotation_factor.factorize(field, elimination);
        std::vector<int> free_elimination;
        for (int i : elimination)
            if (given.place(i) >= 0)
                free_elimination.push_back(given.place(i));
        named([&] { position_factor.factorize(matrix, free_elimination); });
    }

    /// Factorises for the free nodes, and names the node at which it broke down instead of its place among
    /// them.
    template <class Factorize>
    void named(Factorize&& factorize) const
    {
        try {
            factorize();
        } catch (const OutOfMemory&) {
            throw;
        } catch (const FactorizationFailed& failure) {
            if (failure.elements().empty())
                throw;
            throw FactorizationFailed(failure.what(), Error::Element::vertex,
                                      {given.free_nodes()[failure.elements().front()]});
        }
    }

    void sort(const Points& rest)
    {
        enum Kind { free, beside_free, held, out };
        const GraphEdges& edges = given.edges();
        std::vector<char> kind(given.size(), held);
        for (int i = 0; i < given.size(); ++i) {
            if (given.is_idle(i) || given.place(i) >= 0) {
                kind[i] = given.is_idle(i) ? out : free;
                continue;
            }
            const auto first = edges.neighbours.begin() + edges.offsets[i],
                       last = edges.neighbours.begin() + edges.offsets[i + 1];
            if (cells.smoothing > 0 || std::any_of(first, last, [&](int j) { return given.place(j) >= 0; }))
                kind[i] = beside_free;
        }
        const std::vector<std::uint64_t> codes = morton_codes(view(rest));
        order.resize(given.size());
        std::iota(order.begin(), order.end(), 0);
        std::ranges::sort(order, {}, [&](int i) { return std::tuple(kind[i], codes[i], i); });
        const auto until = [&](Kind last) {
            return static_cast<int>(std::ranges::count_if(kind, [&](char k) { return k <= last; }));
        };
        moving_nodes = until(beside_free);
        present_nodes = until(held);
    }
};

ArapSystem::ArapSystem(const HandleGraph& graph, GraphCells cells, const Points& rest, bool factorized)
    : ArapSystem(Parts(graph, std::move(cells), rest, factorized))
{
}

ArapSystem::~ArapSystem() = default;
ArapSystem::ArapSystem(ArapSystem&&) noexcept = default;
ArapSystem& ArapSystem::operator=(ArapSystem&&) noexcept = default;

void ArapSystem::iterate(const Points& rest, const ClusterMap& map, const ArapSystem& coarse)
{
    std::vector<GraphMatrix> matrices(is_smooth() ? 2 : 1);
    GraphMatrix& positions = matrices.front();
    positions = {free_count(), laplacian_, 1.0, std::vector<double>(free_count(), 0.0),
                 &coarse.position_factor()};
    for (const GraphPull& pull : nodes_.pulls())
        positions.own[pull.node] += pull.stiffness;
    if (is_smooth()) {
        const GraphEdges& edges = nodes_.edges();
        if (cells_.rims) {
            turning_ = edges.weights;
            for (int i = 0; i < size(); ++i)
                for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
                    turning_[a] *= cells_.edge_rigidity(i, edges.neighbours[a]);
        }
        matrices.back() = {size(), cells_.rims ? turning_ : laplacian_, 4 * cells_.smoothing,
                           cells_.moments(edges, rest), &coarse.rotation_factor()};
    }
    iteration_ = std::make_unique<const GraphIteration>(nodes_.edges(), map, std::move(matrices));
}

std::int64_t ArapSystem::factor_bytes() const
{
    return iteration_ ? iteration_->bytes() : position_factor_.bytes() + rotation_factor_.bytes();
}

void ArapSystem::solve_positions(const Points& b, Points& x, double error, const Progress& progress) const
{
    if (iteration_)
        iteration_->solve(0, b, x, error, progress);
    else
        position_factor_.solve(b, x);
}

void ArapSystem::solve_rotations(const Points& b, Points& x, double error, const Progress& progress) const
{
    if (iteration_)
        iteration_->solve(1, b, x, error, progress);
    else
        rotation_factor_.solve(b, x);
}

ArapSystem::ArapSystem(Parts&& parts)
    : nodes_(parts.given.renumbered(parts.order)), cells_(std::move(parts.cells)),
      laplacian_(cells_.laplacian(nodes_.edges())), position_factor_(std::move(parts.position_factor)),
      rotation_factor_(std::move(parts.rotation_factor)), rest_scale_(parts.rest_scale),
      order_(std::move(parts.order)),
      chunks_(nodes_.edges(), cells_.triangles, parts.moving_nodes, parts.present_nodes)
{
}

double ArapSystem::scale(const PointsView& base) const
{
    return sum_of_squares(nodes_.edges(), cells_, base);
}

} // namespace sinew
