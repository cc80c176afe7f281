// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/arap.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/higher_order.h"
#include "native/local_global/arap/mesh_graph.h"
#include "native/local_global/arap/multilevel_start.h"
#include "native/local_global/graph/graph_iteration.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/operators/laplacian.h"
#include "native/operators/painted.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double least_rigidity = 1e-3; ///< as a share of the largest painted one
/// An energy below this share of sum w |p_i - p_j|^2 is rounding. Without this floor, rigid poses would
/// iterate on it.
constexpr double rounding_floor = 1e-14;

/// Shares of the tolerance: where no motions of clusters help, ways shrink slowly, and on a small mesh unsteadily.
constexpr double slow_share = 0.1, small_share = 0.2;
constexpr int small = 10000; ///< nodes

std::vector<double> painted_rigidity(const std::vector<double>& rigidity, int n)
{
    std::vector<double> values = painted(rigidity, n, least_rigidity, "rigidity");
    if (values.empty())
        throw InvalidOption("rigidity: zero everywhere; give at least one vertex a positive value");
    return values;
}

/// The half cotangents of the corners of all triangles, kept within bounds so that no term is negative.
std::vector<GraphTriangle> rim_triangles(const SurfaceMesh& mesh, const TriangleMetric& metric,
                                         const WeightBounds& bounds)
{
    std::vector<GraphTriangle> triangles;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
        GraphTriangle triangle;
        for (int k = 0; k < 3; ++k) {
            triangle.corner[k] = mesh.triangles()[t][k];
            triangle.across[k] = bounds.bounded(metric.half_cotan[t][k]);
        }
        triangles.push_back(triangle);
    }
    return triangles;
}

/// The cells and edges of a mesh, which do not depend on handles.
struct RestGraph
{
    GraphCells cells;
    GraphEdges edges;
    std::vector<double> sizes; ///< one per vertex, see part_sizes()

    /// With rims, w_ij is the sum of the bounded half cotangents, so that L is exactly what bounds the
    /// Hessian of the energy.
    RestGraph(const SurfaceMesh& mesh, const ArapOptions& options, const std::vector<double>& rigidity)
        : sizes(part_sizes(mesh))
    {
        const TriangleMetric metric = triangle_metric(mesh);
        cells.rigidity = rigidity;
        cells.smoothing = options.smoothness * std::accumulate(metric.area.begin(), metric.area.end(), 0.0);

        SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
        const WeightBounds bounds(L);
        if (options.cells != ArapOptions::Cells::rims) {
            edges = edges_of(L, bounds);
            return;
        }
        cells.rims = true;
        cells.triangles = rim_triangles(mesh, metric, bounds);
        std::vector<Eigen::Triplet<double>> entries;
        for (const GraphTriangle& t : cells.triangles)
            for (int k = 0; k < 3; ++k) {
                entries.emplace_back(t.corner[(k + 1) % 3], t.corner[(k + 2) % 3], -t.across[k]);
                entries.emplace_back(t.corner[(k + 2) % 3], t.corner[(k + 1) % 3], -t.across[k]);
            }
        L.setFromTriplets(entries.begin(), entries.end());
        // These sums are within no bounds of their own.
        edges = edges_of(L, {0.0, std::numeric_limits<double>::infinity()});
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

/// The workspace of a solve.
struct Workspace
{
    GraphWorkspace fine;
    std::vector<GraphWorkspace> levels;
    Points incoming;
};

/// The results of a bind.
struct Binding
{
    double unit; ///< of the nodes, whose squares fit into single precision
    ArapSystem graph;
    Points node_rest; ///< the rest points of the nodes
    double size = 0.0; ///< of the largest part of those that are not idle
    MultilevelStart cascade;
    std::optional<HigherOrder> higher; ///< with point_handles
    mutable Pool<Workspace> workspaces;

    /// \param rest      (n, 3) in units of `unit`
    /// \param iterates  whether to do without the factors of the mesh.
    Binding(const RestGraph& mesh, double unit, const Points& rest, const Regions& regions, bool iterates,
            const Progress& progress)
        : unit(unit), graph(mesh.held_by(regions), mesh.cells, rest, !iterates), node_rest(rest.rows(), 3)
    {
        for (int i = 0; i < graph.size(); ++i)
            node_rest.row(i) = rest.row(graph.order()[i]);
        for (int i = 0; i < graph.chunks().present(); ++i)
            size = std::max(size, mesh.sizes[graph.order()[i]]);
        cascade = MultilevelStart(graph, node_rest, progress);
        if (!iterates)
            return;
        if (cascade.levels().empty()) // so few vertices, or parts of so few, that nothing is coarser
            graph = ArapSystem(mesh.held_by(regions), mesh.cells, rest);
        else
            graph.iterate(node_rest, cascade.levels().front().map, cascade.levels().front().graph);
    }

    /// \param mass  (n) of the vertices
    void smooth_points(double lambda, const VectorX& mass)
    {
        const double mean = mass.mean();
        std::vector<double> of_nodes;
        for (int v : graph.order())
            of_nodes.push_back(mass[v] / mean);
        higher.emplace(graph, lambda, std::move(of_nodes));
    }

    std::int64_t bytes() const
    {
        return graph.factor_bytes() + cascade.factor_bytes() + (higher ? higher->factor().bytes() : 0);
    }

    /// The points of the first `count` nodes.
    void to_nodes(const PointsView& points, int count, Points& nodes) const
    {
        nodes.resize(count, 3);
        parallel_for(count,
                     [&, scale = 1.0 / unit](int i) { nodes.row(i) = scale * points.row(graph.order()[i]); });
    }
    void to_vertices(const PointsView& nodes, Points& points) const
    {
        points.resize(nodes.rows(), 3);
        parallel_for(graph.size(), [&](int i) { points.row(graph.order()[i]) = unit * nodes.row(i); });
    }
    /// Poses of the nodes.
    Poses to_nodes(Poses poses) const
    {
        for (Pose& pose : poses)
            pose.col(3) /= unit;
        return poses;
    }
    /// E for its value in units of the nodes.
    double energy(double of_nodes) const { return of_nodes * graph.energy_factor() * unit * unit; }
};

} // namespace

struct Arap::Impl
{
    std::vector<double> rigidity;       ///< one per vertex
    double unit = 1.0; ///< see normal_unit()
    std::optional<RestGraph> assembled; ///< by the first bind
    int degenerate_faces = 0;           ///< counted by the first bind
    int factorizations = 0;
    std::unique_ptr<const Binding> bound; ///< null before the first bind
};

Arap::Arap(const SurfaceMesh& rest, const ArapOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    if (options.point_handles > 0.0 && options.cells == ArapOptions::Cells::rims)
        throw InvalidOption("point_handles: only with cells of spokes; set it to 0, or take spokes");
    impl_->unit = normal_unit(rest.points());
    impl_->rigidity = painted_rigidity(options.rigidity, rest.vertex_count());
}

void Arap::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const std::optional<SurfaceMesh> scaled = in_unit(rest(), self.unit);
    const SurfaceMesh& mesh = scaled ? *scaled : rest();
    if (!self.assembled) {
        self.assembled.emplace(mesh, options(), self.rigidity);
        self.degenerate_faces = degenerate_face_count(mesh);
    }
    const double lambda = options().point_handles;
    std::unique_ptr<Binding> next;
    const auto make = [&](bool iterates) {
        progress.tick(0.2, iterates ? "building the multigrid" : "factorising");
        if (iterates)
            require_memory(GraphIteration::bytes_for(mesh.vertex_count()), "the multigrid");
        next =
            std::make_unique<Binding>(*self.assembled, self.unit, mesh.points(), regions, iterates, progress);
        if (lambda > 0 && next->graph.free_count() > 0)
            next->smooth_points(lambda, divisible_mass(mesh, Discretization::cotan_voronoi));
    };
    const auto free = static_cast<int>(std::ranges::count(regions.free_vertices(), true));
    const std::string why =
        bind_by(options().solver,
                {.free = free,
                 .factor_bytes = (self.assembled->cells.smoothing > 0 ? 1.5 : 1.0) * factor_bytes(free, 1),
                 .unsuited = lambda > 0 ? "point_handles must be 0 for the multigrid" : "",
                 .factorize = [&] { make(false); },
                 .iterate = [&] { make(true); }});
    progress.tick(1.0, "bound");

    self.bound = std::move(next);
    if (!self.bound->graph.iterates())
        self.factorizations += (self.bound->graph.is_smooth() ? 2 : 1) + (self.bound->higher ? 1 : 0);
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = self.factorizations;
    report.factor_bytes = self.bound->bytes();
    remark_iterations(report, why);
}

void Arap::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<Arap&>(other).impl_;
    std::swap(impl_->assembled, others.assembled);
    std::swap(impl_->degenerate_faces, others.degenerate_faces);
    std::swap(impl_->factorizations, others.factorizations);
    std::swap(impl_->bound, others.bound);
}

SolveReport Arap::deform(const SolveRequest& request, const Targets& given, Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const ArapSystem& graph = bound.graph;
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(this->options().max_iterations),
                         .tolerance = request.tolerance.value_or(this->options().tolerance),
                         .size = bound.size};

    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    GraphWorkspace& fine = work->fine;
    const Poses poses = bound.to_nodes(given.poses);
    Targets targets{poses, view(bound.node_rest), {}, given.from_rest};
    if (given.incoming) {
        bound.to_nodes(*given.incoming, graph.size(), work->incoming);
        targets.incoming.emplace(view(work->incoming));
    }
    fine.goals.set(graph, targets);
    if (graph.free_count() == 0) {
        bound.to_vertices(view(fine.goals.targets), positions);
        return {.converged = true};
    }
    ArapProblem problem(graph, targets.base(), fine.goals.targets, fine.goals.pulls, &fine.buffers);
    double reached = 0.0; // by the steps; the iterations within one only ask whether to go on
    const Progress steps([&](double share, const char* stage) {
        request.progress.tick(reached = share, stage);
        return true;
    });
    const Progress within([&](double, const char* stage) {
        request.progress.tick(reached, stage);
        return true;
    });
    problem.watch(within);
    options.floor = rounding_floor * (given.incoming ? graph.scale(targets.base()) : graph.rest_scale());
    CascadeSolve cascade(bound.cascade, problem, graph, targets, work->levels);
    if (request.start) {
        bound.to_nodes(*request.start, graph.free_count(), fine.x);
        if (graph.is_smooth()) // without smoothing, the first evaluation fits them
            problem.local_step(fine.x);
    } else {
        cascade.start();
        problem.global_step(fine.x);
    }
    if (bound.higher || bound.cascade.motions(0).empty())
        options.tolerance *= slow_share;
    else if (graph.chunks().present() < small)
        options.tolerance *= small_share;
    SolveReport report;
    if (bound.higher) {
        HigherOrderProblem higher(graph, *bound.higher, problem, targets.base(), fine.goals.pulls);
        if (!request.start)
            higher.global_step(fine.x);
        options.plain_steps = 4;
        report = minimize(higher, fine.x, options, steps, &fine.descent);
    } else {
        report = minimize(problem, fine.x, options, steps, &fine.descent);
    }
    report.energy = bound.energy(report.energy);
    bound.to_vertices(problem.place(fine.x), positions);
    return report;
}

double Arap::energy(const PointsView& positions) const
{
    require_same_size(positions, "positions");
    const AccessLock shared = reading();
    if (!impl_->bound)
        return 0.0;
    const Binding& bound = *impl_->bound;
    const ArapSystem& graph = bound.graph;
    const std::vector<GraphPull>& soft = graph.nodes().pulls();
    Points all;
    bound.to_nodes(positions, graph.size(), all);
    Points pulls(soft.size(), 3); // pulls to where the nodes are, which have no energy
    for (std::size_t k = 0; k < soft.size(); ++k)
        pulls.row(k) = all.row(soft[k].node);
    ArapProblem problem(graph, view(bound.node_rest), all, pulls);
    const Points x = problem.free_rows(view(all));
    Points gradient;
    problem.local_step(x);
    double energy = problem.evaluate(x, gradient);
    for (int k = 0; graph.is_smooth() && k < 500; ++k) {
        const double next = problem.evaluate(x, gradient);
        if (!(next < energy * (1 - 1e-9)))
            break;
        energy = next;
    }
    return bound.energy(energy);
}

} // namespace sinew
