// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/laplacian.h"
#include "native/operators/painted.h"
#include "native/surface/nonlinear/arap/cascade.h"
#include "native/surface/nonlinear/arap/energy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>

namespace sinew {

namespace {

constexpr double least_weight = 1e-6; ///< of the mean: keeps the graph connected
constexpr double most_weight = 1e4;   ///< of the mean: keeps the factor well conditioned
constexpr double least_rigidity = 1e-3; ///< of the largest painted one
/// F below this share of sum w |p|^2 is rounding: rigid poses would iterate on it.
constexpr double rounding_floor = 1e-14;

void require_range(double value, double least, const char* name)
{
    if (!(value >= least && std::isfinite(value)))
        throw InvalidOption(std::string(name) + ": " + std::to_string(value) +
                            " is not a finite number >= " + std::to_string(least));
}

std::vector<double> painted_rigidity(const std::vector<double>& rigidity, int n)
{
    std::vector<double> values = painted(rigidity, n, least_rigidity, "rigidity");
    if (values.empty())
        throw InvalidOption("rigidity: zero everywhere; give at least one vertex a positive value");
    return values;
}

/// Half cotangents by triangle corner, each raised so that every cell stays positive.
std::vector<ArapTriangle> rim_triangles(const SurfaceMesh& mesh, const TriangleMetric& metric, double mean)
{
    std::vector<ArapTriangle> triangles;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
        ArapTriangle triangle;
        for (int k = 0; k < 3; ++k) {
            triangle.corner[k] = mesh.triangles()[t][k];
            triangle.across[k] = std::clamp(metric.half_cotan[t][k], least_weight * mean, most_weight * mean);
        }
        triangles.push_back(triangle);
    }
    return triangles;
}

/// A mesh as ARAP sees it, before any handle.
struct RestGraph
{
    ArapCells cells;
    GraphEdges edges;

    /// With rims, w_ij is the sum of the corners' raised cotangents, so that L is exactly the Hessian bound
    /// of the rims' energy.
    RestGraph(const SurfaceMesh& mesh, const ArapOptions& options)
    {
        const TriangleMetric metric = triangle_metric(mesh);
        cells.rigidity = painted_rigidity(options.rigidity, mesh.vertex_count());
        cells.smoothing = options.smoothness * std::accumulate(metric.area.begin(), metric.area.end(), 0.0);

        SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
        double sum = 0.0;
        int count = 0;
        for (int c = 0; c < L.cols(); ++c)
            for (SparseMatrix::InnerIterator it(L, c); it; ++it)
                if (it.row() != c) {
                    sum += std::abs(it.value());
                    ++count;
                }
        const double mean = sum > 0 ? sum / count : 1.0;
        if (options.cells == ArapOptions::Cells::rims) {
            cells.rims = true;
            cells.triangles = rim_triangles(mesh, metric, mean);
            std::vector<Eigen::Triplet<double>> entries;
            for (const ArapTriangle& t : cells.triangles)
                for (int k = 0; k < 3; ++k) {
                    entries.emplace_back(t.corner[(k + 1) % 3], t.corner[(k + 2) % 3], -t.across[k]);
                    entries.emplace_back(t.corner[(k + 2) % 3], t.corner[(k + 1) % 3], -t.across[k]);
                }
            L.setFromTriplets(entries.begin(), entries.end());
        }

        for (int c = 0; c < L.cols(); ++c) {
            for (SparseMatrix::InnerIterator it(L, c); it; ++it)
                if (it.row() != c) {
                    edges.neighbours.push_back(static_cast<int>(it.row()));
                    edges.weights.push_back(
                        cells.rims ? -it.value()
                                   : std::clamp(-it.value(), least_weight * mean, most_weight * mean));
                }
            edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
        }
    }

    HandleGraph held_by(const Regions& regions) const
    {
        const std::vector<double> laplacian =
            regions.soft().empty() ? std::vector<double>() : cells.laplacian(edges);
        return {edges, GraphHandles(regions, [&](int vertex) {
                    double diagonal = 0.0;
                    for (int a = edges.offsets[vertex]; a < edges.offsets[vertex + 1]; ++a)
                        diagonal += laplacian[a];
                    return diagonal;
                })};
    }
};

/// What a bind makes.
struct Binding
{
    ArapGraph graph;
    Points node_rest; ///< rest points by node
    ArapCascade cascade;
    int handle_count;

    Binding(const RestGraph& mesh, const Points& rest, const Regions& regions, const Progress& progress)
        : graph(mesh.held_by(regions), mesh.cells, rest), node_rest(rest.rows(), 3),
          handle_count(regions.handle_count())
    {
        for (int i = 0; i < graph.size(); ++i)
            node_rest.row(i) = rest.row(graph.order()[i]);
        cascade = ArapCascade(graph, node_rest, progress);
    }

    /// The points of the first `count` nodes.
    void to_nodes(const PointsView& points, int count, Points& nodes) const
    {
        nodes.resize(count, 3);
        parallel_for(count, [&](int i) { nodes.row(i) = points.row(graph.order()[i]); });
    }
    void to_vertices(const PointsView& nodes, Points& points) const
    {
        points.resize(nodes.rows(), 3);
        parallel_for(graph.size(), [&](int i) { points.row(graph.order()[i]) = nodes.row(i); });
    }
};

} // namespace

struct Arap::Impl
{
    SurfaceMesh rest;
    ArapOptions options;
    Components parts;
    int degenerate_faces;
    int factorizations = 0;
    RestGraph rest_graph;
    std::unique_ptr<const Binding> bound; ///< null before any handle: nothing moves

    Impl(const SurfaceMesh& mesh, const ArapOptions& given)
        : rest(mesh), options(checked(given)), parts(connected_components(rest)),
          degenerate_faces(degenerate_face_count(rest)), rest_graph(rest, options)
    {
    }

    static const ArapOptions& checked(const ArapOptions& options)
    {
        require_range(options.smoothness, 0.0, "smoothness");
        require_range(options.tolerance, 0.0, "tolerance");
        require_range(options.max_iterations, 1, "max_iterations");
        return options;
    }

    /// What a solve works in.
    struct Workspace
    {
        ArapWorkspace fine;
        std::vector<ArapWorkspace> levels;
        Points incoming;
    };
    mutable Pool<Workspace> workspaces;

    void require_same_size(const PointsView& points, const char* name) const
    {
        if (points.rows() != rest.vertex_count())
            throw InvalidConstraint(std::string(name) + ": " + std::to_string(points.rows()) +
                                    " points given for a rest shape of " +
                                    std::to_string(rest.vertex_count()));
        if (!points.allFinite())
            throw InvalidConstraint(std::string(name) + ": NaN or infinite coordinates");
    }
};

Arap::Arap(const SurfaceMesh& rest, const ArapOptions& options) : impl_(std::make_unique<Impl>(rest, options))
{
}

Arap::~Arap() = default;
Arap::Arap(Arap&&) noexcept = default;

BindReport Arap::set_handles(const std::vector<Handle>& handles, const Progress& progress)
{
    const auto start = std::chrono::steady_clock::now();
    Impl& self = *impl_;
    progress.tick(0.0, "assembling the energy");
    const Regions regions(handles, self.parts);
    progress.tick(0.2, "factorising");
    auto bound = std::make_unique<const Binding>(self.rest_graph, self.rest.points(), regions, progress);
    progress.tick(1.0, "bound");

    self.bound = std::move(bound);
    self.workspaces.clear();
    self.factorizations += self.bound->graph.is_smooth() ? 2 : 1;

    BindReport report = regions.report();
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = self.factorizations;
    report.factor_bytes = self.bound->graph.factor_bytes();
    for (const ArapLevel& level : self.bound->cascade.levels())
        report.factor_bytes += level.graph.factor_bytes();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

SolveReport Arap::solve(const Poses& poses, Points& positions, const Request& request,
                        const Progress& progress) const
{
    const Impl& self = *impl_;
    const Targets given{poses, view(self.rest.points()), request.incoming, request.from_rest};
    given.check(self.bound ? self.bound->handle_count : 0);
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(self.options.max_iterations),
                         .tolerance = request.tolerance.value_or(self.options.tolerance)};
    require_range(options.max_iterations, 0, "max_iterations");
    require_range(options.tolerance, 0.0, "tolerance");
    if (request.start)
        self.require_same_size(*request.start, "start");

    if (!self.bound) {
        positions = given.base();
        return SolveReport{.converged = true};
    }

    const Binding& bound = *self.bound;
    const ArapGraph& graph = bound.graph;
    const auto work = self.workspaces.take([] { return std::make_unique<Impl::Workspace>(); });
    ArapWorkspace& fine = work->fine;
    Targets targets{poses, view(bound.node_rest), {}, request.from_rest};
    if (request.incoming) {
        bound.to_nodes(*request.incoming, graph.size(), work->incoming);
        targets.incoming.emplace(view(work->incoming));
    }
    fine.goals.set(graph, targets);
    SolveReport report{.converged = true};
    if (graph.free_count() == 0) {
        bound.to_vertices(view(fine.goals.targets), positions);
    } else {
        ArapProblem problem(graph, targets.base(), fine.goals.targets, fine.goals.pulls, &fine.buffers);
        options.floor =
            rounding_floor * (request.incoming ? graph.scale(targets.base()) : graph.rest_scale());
        if (request.start) {
            bound.to_nodes(*request.start, graph.free_count(), fine.x);
            if (graph.is_smooth()) // else the first evaluation does
                problem.fit_rotations(fine.x);
        } else {
            bound.cascade.start(problem, graph, targets, work->levels);
            problem.positions_for_rotations(fine.x);
        }
        report = minimize(problem, fine.x, options, progress, &fine.descent);
        report.energy *= graph.energy_factor();
        bound.to_vertices(problem.place(fine.x), positions);
    }
    return report;
}

double Arap::energy(const PointsView& positions) const
{
    const Impl& self = *impl_;
    self.require_same_size(positions, "positions");
    if (!self.bound)
        return 0.0;
    const ArapGraph& graph = self.bound->graph;
    const std::vector<GraphPull>& soft = graph.nodes().pulls();
    Points all;
    self.bound->to_nodes(positions, graph.size(), all);
    Points pulls(soft.size(), 3); // already where they would go: no energy
    for (std::size_t k = 0; k < soft.size(); ++k)
        pulls.row(k) = all.row(soft[k].node);
    ArapProblem problem(graph, view(self.bound->node_rest), all, pulls);
    const Points x = problem.free_rows(view(all));
    Points gradient;
    problem.fit_rotations(x);
    double energy = problem.evaluate(x, gradient);
    for (int k = 0; graph.is_smooth() && k < 500; ++k) {
        const double next = problem.evaluate(x, gradient);
        if (!(next < energy * (1 - 1e-9)))
            break;
        energy = next;
    }
    return energy * graph.energy_factor();
}

const SurfaceMesh& Arap::rest() const { return impl_->rest; }

} // namespace sinew
