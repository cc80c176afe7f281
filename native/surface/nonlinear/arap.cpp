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
ArapGraph make_graph(const SurfaceMesh& mesh, const ArapOptions& options)
{
    ArapGraph graph;
    graph.size = mesh.vertex_count();
    graph.rigidity = painted_rigidity(options.rigidity, graph.size);
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

} // namespace

struct Arap::Impl
{
    SurfaceMesh rest;
    ArapOptions options;
    Components parts;
    int degenerate_faces;
    int factorizations = 0;
    int handle_count = 0;
    ArapGraph graph;
    std::vector<int> vertex; ///< of each node of the graph
    Points node_rest;        ///< rest points by node
    ArapCascade cascade;

    Impl(const SurfaceMesh& mesh, const ArapOptions& given)
        : rest(mesh), options(given), parts(connected_components(rest)),
          degenerate_faces(degenerate_face_count(rest))
    {
        require_range(options.smoothness, 0.0, "smoothness");
        require_range(options.tolerance, 0.0, "tolerance");
        require_range(options.max_iterations, 1, "max_iterations");
        graph = make_graph(rest, options);
        adopt(graph, Regions({}, parts));
        graph.place.assign(graph.size, -1);
        vertex.resize(graph.size);
        std::iota(vertex.begin(), vertex.end(), 0);
        node_rest = rest.points();
    }

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

    /// What a solve works in.
    struct Workspace
    {
        ArapWorkspace fine;
        std::vector<ArapWorkspace> levels;
        Points incoming;
    };
    mutable Pool<Workspace> workspaces;

    static void adopt(ArapGraph& graph, const Regions& regions)
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
    ArapGraph graph = make_graph(self.rest, self.options);
    Impl::adopt(graph, regions);
    progress.tick(0.2, "factorising");
    graph.factorize(self.rest.points());
    std::vector<int> vertex = graph.renumber(self.rest.points());
    Points node_rest(self.rest.vertex_count(), 3);
    for (int i = 0; i < graph.size; ++i)
        node_rest.row(i) = self.rest.points().row(vertex[i]);
    ArapCascade cascade(graph, node_rest, progress);
    progress.tick(1.0, "bound");

    self.graph = std::move(graph);
    self.vertex = std::move(vertex);
    self.node_rest = std::move(node_rest);
    self.cascade = std::move(cascade);
    self.workspaces.clear();
    self.handle_count = regions.handle_count();
    self.factorizations += self.graph.smoothing > 0 ? 2 : 1;

    BindReport report = regions.report();
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = self.factorizations;
    report.factor_bytes = self.graph.factor_bytes();
    for (const ArapLevel& level : self.cascade.levels())
        report.factor_bytes += level.graph.factor_bytes();
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

SolveReport Arap::solve(const Poses& poses, Points& positions, const Request& request,
                        const Progress& progress) const
{
    const Impl& self = *impl_;
    Targets{poses, view(self.rest.points()), request.incoming, request.from_rest}.check(self.handle_count);
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(self.options.max_iterations),
                         .tolerance = request.tolerance.value_or(self.options.tolerance)};
    require_range(options.max_iterations, 0, "max_iterations");
    require_range(options.tolerance, 0.0, "tolerance");
    if (request.start)
        self.require_same_size(*request.start, "start");

    const auto work = self.workspaces.take([] { return std::make_unique<Impl::Workspace>(); });
    ArapWorkspace& fine = work->fine;
    Targets targets{poses, view(self.node_rest), {}, request.from_rest};
    if (request.incoming) {
        self.to_nodes(*request.incoming, self.graph.size, work->incoming);
        targets.incoming.emplace(view(work->incoming));
    }
    fine.goals.set(self.graph, targets);
    SolveReport report{.converged = true};
    if (self.graph.free_nodes.empty()) {
        self.to_vertices(view(fine.goals.targets), positions);
    } else {
        ArapProblem problem(self.graph, targets.base(), fine.goals.targets, fine.goals.pulls, &fine.buffers);
        options.floor =
            rounding_floor * (request.incoming ? self.graph.scale(targets.base()) : self.graph.rest_scale);
        if (request.start) {
            self.to_nodes(*request.start, self.graph.free_count(), fine.x);
            if (self.graph.smoothing > 0) // else the first evaluation does
                problem.fit_rotations(fine.x);
        } else {
            self.cascade.start(problem, self.graph, targets, work->levels);
            problem.positions_for_rotations(fine.x);
        }
        report = minimize(problem, fine.x, options, progress, &fine.descent);
        report.energy *= self.graph.energy_factor();
        self.to_vertices(problem.place(fine.x), positions);
    }
    return report;
}

double Arap::energy(const PointsView& positions) const
{
    const Impl& self = *impl_;
    self.require_same_size(positions, "positions");
    Points all;
    self.to_nodes(positions, self.graph.size, all);
    Points pulls(self.graph.pulls.size(), 3); // already where they would go: no energy
    for (std::size_t k = 0; k < self.graph.pulls.size(); ++k)
        pulls.row(k) = all.row(self.graph.pulls[k].node);
    ArapProblem problem(self.graph, view(self.node_rest), all, pulls);
    const Points x = problem.free_rows(view(all));
    Points gradient;
    problem.fit_rotations(x);
    double energy = problem.evaluate(x, gradient);
    for (int k = 0; self.graph.smoothing > 0 && k < 500; ++k) {
        const double next = problem.evaluate(x, gradient);
        if (!(next < energy * (1 - 1e-9)))
            break;
        energy = next;
    }
    return energy * self.graph.energy_factor();
}

const SurfaceMesh& Arap::rest() const { return impl_->rest; }

} // namespace sinew
