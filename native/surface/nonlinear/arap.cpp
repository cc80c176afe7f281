// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/laplacian.h"
#include "native/surface/nonlinear/arap_cascade.h"
#include "native/surface/nonlinear/arap_energy.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double least_weight = 1e-6; ///< of the mean: keeps the graph connected
constexpr double most_weight = 1e4;   ///< of the mean: keeps the factor well conditioned
constexpr double least_rigidity = 1e-3; ///< of the largest painted one
/// F below this share of sum w |p|^2 is rounding: rigid poses would iterate on it.
constexpr double rounding_floor = 1e-14;

std::vector<double> spread_rigidity(const std::vector<double>& rigidity, int n)
{
    if (rigidity.size() != 1 && static_cast<int>(rigidity.size()) != n)
        throw InvalidOption("rigidity: " + std::to_string(rigidity.size()) +
                            " values given; 1 or one a vertex (" + std::to_string(n) + ") needed");
    std::vector<int> bad;
    for (int i = 0; i < static_cast<int>(rigidity.size()); ++i)
        if (!(rigidity[i] >= 0 && std::isfinite(rigidity[i])))
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidOption("rigidity: values at " + list_some(bad) + " are not finite numbers >= 0",
                            Error::Element::vertex, bad);
    const double largest = *std::ranges::max_element(rigidity);
    if (!(largest > 0))
        throw InvalidOption("rigidity: zero everywhere; give at least one vertex a positive value");
    std::vector<double> values = rigidity.size() == 1 ? std::vector<double>(n, rigidity[0]) : rigidity;
    for (double& value : values)
        value = std::max(value, least_rigidity * largest);
    return values;
}

/// Half cotangents by triangle corner, each raised so that every cell stays positive.
void add_triangles(ArapGraph& graph, const SurfaceMesh& mesh, const TriangleMetric& metric, double mean)
{
    graph.rims = true;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
        ArapTriangle triangle;
        for (int k = 0; k < 3; ++k) {
            triangle.corner[k] = mesh.triangles()[t][k];
            triangle.across[k] = std::clamp(metric.half_cotan[t][k], least_weight * mean, most_weight * mean);
        }
        graph.triangles.push_back(triangle);
    }
}

/// Directed edges and weights. With rims, w_ij is the sum of the corners' raised cotangents,
/// so that L is exactly the Hessian bound of the rims' energy.
ArapGraph make_graph(const SurfaceMesh& mesh, const ArapOptions& options, const std::vector<double>& rigidity)
{
    ArapGraph graph;
    graph.size = mesh.vertex_count();
    graph.rigidity = rigidity;
    const TriangleMetric metric = triangle_metric(mesh);
    graph.smoothing = options.smoothness * std::accumulate(metric.area.begin(), metric.area.end(), 0.0);

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
        add_triangles(graph, mesh, metric, mean);
        std::vector<Eigen::Triplet<double>> entries;
        for (const ArapTriangle& t : graph.triangles)
            for (int k = 0; k < 3; ++k) {
                entries.emplace_back(t.corner[(k + 1) % 3], t.corner[(k + 2) % 3], -t.across[k]);
                entries.emplace_back(t.corner[(k + 2) % 3], t.corner[(k + 1) % 3], -t.across[k]);
            }
        L.setFromTriplets(entries.begin(), entries.end());
    }

    graph.offsets.assign(1, 0);
    for (int c = 0; c < L.cols(); ++c) {
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                graph.neighbours.push_back(static_cast<int>(it.row()));
                graph.weights.push_back(
                    graph.rims ? -it.value()
                               : std::clamp(-it.value(), least_weight * mean, most_weight * mean));
            }
        graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
    }
    graph.set_metric();
    return graph;
}

/// What make_graph() filled: the rest depends on the regions.
ArapGraph unbound_copy(const ArapGraph& graph)
{
    ArapGraph copy;
    copy.size = graph.size;
    copy.offsets = graph.offsets;
    copy.neighbours = graph.neighbours;
    copy.weights = graph.weights;
    copy.rims = graph.rims;
    copy.triangles = graph.triangles;
    copy.rigidity = graph.rigidity;
    copy.smoothing = graph.smoothing;
    copy.metric = graph.metric;
    return copy;
}

void adopt(ArapGraph& graph, const Regions& regions)
{
    graph.hard.resize(graph.size);
    graph.idle.resize(graph.size);
    for (int i = 0; i < graph.size; ++i) {
        graph.hard[i] = regions.hard(i);
        graph.idle[i] = regions.is_idle(i);
    }
    graph.pulls.clear();
    for (const SoftConstraint& s : regions.soft()) {
        double diagonal = 0.0;
        for (int a = graph.offsets[s.vertex]; a < graph.offsets[s.vertex + 1]; ++a)
            diagonal += graph.metric[a];
        graph.pulls.push_back({s.vertex, s.handle, s.stiffness() * (diagonal > 0 ? diagonal : 1.0)});
    }
}

/// What a solve works in: kept for the next one, each of several at once takes its own.
struct Workspace
{
    ArapWorkspace fine;
    std::vector<ArapWorkspace> levels;
    Points incoming;
};

/// What a bind makes. Replaced as a whole, so a bind that fails changes nothing.
struct Binding
{
    ArapGraph graph;
    std::vector<int> vertex; ///< of each node of the graph
    Points node_rest;        ///< rest points by node
    ArapCascade cascade;
    std::unique_ptr<Pool<Workspace>> workspaces = std::make_unique<Pool<Workspace>>();
    int factorizations = 0;

    /// The points of the first `count` nodes.
    void to_nodes(const PointsView& points, int count, Points& nodes) const
    {
        nodes.resize(count, 3);
        parallel_for(count, [&](int i) { nodes.row(i) = points.row(vertex[i]); });
    }
    void to_vertices(const PointsView& nodes, Points& points) const
    {
        points.resize(nodes.rows(), 3);
        parallel_for(graph.size, [&](int i) { points.row(vertex[i]) = nodes.row(i); });
    }
};

} // namespace

struct Arap::Impl
{
    ArapOptions options;
    std::vector<double> rigidity;       ///< one per vertex
    std::optional<ArapGraph> assembled; ///< of the mesh without regions, from the first bind on
    int degenerate_faces = 0;           ///< found then
    Binding bound;
};

Arap::Arap(const SurfaceMesh& rest, const ArapOptions& options)
    : SurfaceMethod(rest), impl_(std::make_unique<Impl>())
{
    require_at_least(options.smoothness, 0.0, "smoothness");
    require_at_least(options.tolerance, 0.0, "tolerance");
    require_at_least(options.max_iterations, 1, "max_iterations");
    impl_->options = options;
    impl_->rigidity = spread_rigidity(options.rigidity, rest.vertex_count());
}

Arap::~Arap() = default;
Arap::Arap(Arap&&) noexcept = default;

void Arap::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    if (!self.assembled) {
        self.assembled = make_graph(rest(), self.options, self.rigidity);
        self.degenerate_faces = degenerate_face_count(rest());
    }
    Binding next;
    next.graph = unbound_copy(*self.assembled);
    adopt(next.graph, regions);
    progress.tick(0.2, "factorising");
    next.graph.factorize(rest().points());
    next.vertex = next.graph.renumber(rest().points());
    next.node_rest.resize(rest().vertex_count(), 3);
    for (int i = 0; i < next.graph.size; ++i)
        next.node_rest.row(i) = rest().points().row(next.vertex[i]);
    next.cascade = ArapCascade(next.graph, next.node_rest, progress);
    progress.tick(1.0, "bound");

    next.factorizations = self.bound.factorizations + (next.graph.smoothing > 0 ? 2 : 1);
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = next.factorizations;
    report.factor_bytes = next.graph.factor_bytes();
    for (const ArapLevel& level : next.cascade.levels())
        report.factor_bytes += level.graph.factor_bytes();
    self.bound = std::move(next);
}

std::vector<std::string> Arap::changed_options(const SurfaceMethod& former) const
{
    const ArapOptions &own = impl_->options, &other = static_cast<const Arap&>(former).impl_->options;
    return names_of({{"smoothness", own.smoothness != other.smoothness},
                     {"cells", own.cells != other.cells},
                     {"rigidity", own.rigidity != other.rigidity}});
}

bool Arap::updates(const std::string&) const { return false; }

void Arap::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<Arap&>(other).impl_;
    std::swap(impl_->assembled, others.assembled);
    std::swap(impl_->degenerate_faces, others.degenerate_faces);
    std::swap(impl_->bound, others.bound);
}

SolveReport Arap::deform(const SolveRequest& request, const Targets& given, Points& positions) const
{
    const Binding& bound = impl_->bound;
    const ArapGraph& graph = bound.graph;
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(impl_->options.max_iterations),
                         .tolerance = request.tolerance.value_or(impl_->options.tolerance)};

    const auto work = bound.workspaces->take([] { return std::make_unique<Workspace>(); });
    ArapWorkspace& fine = work->fine;
    Targets targets{given.poses, view(bound.node_rest), {}, given.from_rest};
    if (given.incoming) {
        bound.to_nodes(*given.incoming, graph.size, work->incoming);
        targets.incoming.emplace(view(work->incoming));
    }
    fine.goals.set(graph, targets);
    if (graph.free_nodes.empty()) {
        bound.to_vertices(view(fine.goals.targets), positions);
        return {.converged = true};
    }
    ArapProblem problem(graph, targets.base(), fine.goals.targets, fine.goals.pulls, &fine.buffers);
    options.floor = rounding_floor * (given.incoming ? graph.scale(targets.base()) : graph.rest_scale);
    if (request.start) {
        bound.to_nodes(*request.start, graph.free_count(), fine.x);
        if (graph.smoothing > 0) // else the first evaluation does
            problem.fit_rotations(fine.x);
    } else {
        bound.cascade.start(problem, graph, targets, work->levels);
        problem.positions_for_rotations(fine.x);
    }
    SolveReport report = minimize(problem, fine.x, options, request.progress, &fine.descent);
    report.energy *= graph.energy_factor();
    bound.to_vertices(problem.place(fine.x), positions);
    return report;
}

double Arap::energy(const PointsView& positions) const
{
    const Binding& bound = impl_->bound;
    const ArapGraph& graph = bound.graph;
    require_same_size(positions, "positions");
    if (graph.size == 0) // before set_handles()
        return 0.0;
    Points all;
    bound.to_nodes(positions, graph.size, all);
    Points pulls(graph.pulls.size(), 3); // already where they would go: no energy
    for (std::size_t k = 0; k < graph.pulls.size(); ++k)
        pulls.row(k) = all.row(graph.pulls[k].node);
    ArapProblem problem(graph, view(bound.node_rest), all, pulls);
    const Points x = problem.free_rows(view(all));
    Points gradient;
    problem.fit_rotations(x);
    double energy = problem.evaluate(x, gradient);
    for (int k = 0; graph.smoothing > 0 && k < 500; ++k) {
        const double next = problem.evaluate(x, gradient);
        if (!(next < energy * (1 - 1e-9)))
            break;
        energy = next;
    }
    return energy * graph.energy_factor();
}

} // namespace sinew
