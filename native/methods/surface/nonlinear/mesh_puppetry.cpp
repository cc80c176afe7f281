// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_puppetry.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/handles/constrained_system.h"
#include "native/handles/handle_fields.h"
#include "native/handles/map_blend.h"
#include "native/local_global/rows/row_problem.h"
#include "native/local_global/rows/row_system.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/operators/laplacian.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace sinew {

namespace {

constexpr double least_weight = 1e-6; ///< as a share of the mean weight; keeps the surface connected
constexpr double most_weight = 1e3;   ///< likewise; keeps the factor well conditioned
/// An energy below this share of that of all edges is rounding.
constexpr double rounding_floor = 1e-14;

/// L with weights that are positive, so that no edge is lost and all terms of the energy are.
SparseMatrix positive_laplacian(const SurfaceMesh& mesh, const TriangleMetric& metric)
{
    SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan, metric);
    double sum = 0.0;
    int count = 0;
    for (int c = 0; c < L.cols(); ++c)
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                sum += std::max(0.0, -it.value());
                ++count;
            }
    const double mean = count > 0 && sum > 0 ? sum / count : 1.0;
    for (int c = 0; c < L.cols(); ++c) {
        double diagonal = 0.0;
        for (SparseMatrix::InnerIterator it(L, c); it; ++it)
            if (it.row() != c) {
                it.valueRef() = -std::clamp(-it.value(), least_weight * mean, most_weight * mean);
                diagonal -= it.value();
            }
        L.coeffRef(c, c) = diagonal;
    }
    return L;
}

RowTable rows_of(const SurfaceMesh& mesh, const TriangleMetric& metric, const SparseMatrix& L, double bending,
                 const Regions& regions)
{
    const int n = mesh.vertex_count();
    const VectorX mass = divisible_mass(mesh, Discretization::cotan_voronoi, metric);
    const double area = std::accumulate(metric.area.begin(), metric.area.end(), 0.0);
    RowTable rows(n, n);
    std::vector<double> diagonal(n, 0.0);
    std::vector<RowTable::Term> ring;
    const auto add = [&](double weight, int group) {
        rows.add(weight, ring, group);
        for (const auto& [point, coefficient] : ring)
            diagonal[point] += weight * coefficient * coefficient;
    };
    for (int i = 0; i < n; ++i) {
        for (SparseMatrix::InnerIterator it(L, i); it; ++it)
            if (it.row() != i) {
                ring = {{i, 1.0}, {static_cast<int>(it.row()), -1.0}};
                add(-it.value(), i);
            }
        ring.clear();
        for (SparseMatrix::InnerIterator it(L, i); it; ++it)
            ring.push_back({static_cast<int>(it.row()), it.value()});
        if (ring.size() > 1)
            add(bending * area / mass[i], i);
    }
    const double sum = std::accumulate(diagonal.begin(), diagonal.end(), 0.0);
    for (const SoftConstraint& soft : regions.soft()) // a loose vertex has no diagonal entry
        rows.pull(soft.vertex, soft.stiffness() * (diagonal[soft.vertex] > 0 ? diagonal[soft.vertex]
                                                   : sum > 0                 ? sum / n
                                                                             : 1.0));
    return rows;
}

/// The workspace of a solve.
struct Workspace
{
    RotationVectors vectors;
    RotationBuffers buffers;
    LbfgsWorkspace descent;
    RowMatrix blended;
    Points base, held, pulls, x;
};

/// The results of a bind.
struct Binding
{
    double unit; ///< of the points of the cells, whose squares fit into single precision
    std::int64_t factor_bytes; ///< of the larger factor, in the double precision that it is computed in
    HandleFields fields;
    RowSystem cells;
    std::vector<std::vector<int>> patches;
    mutable Pool<Workspace> workspaces;
};

std::unique_ptr<const Binding> bound(const SurfaceMesh& mesh, double unit, const Regions& regions,
                                     double bending, const Progress& progress)
{
    const TriangleMetric metric = triangle_metric(mesh, least_area_for_order(2));
    auto L = std::make_shared<SparseMatrix>(positive_laplacian(mesh, metric));
    const RowTable rows = rows_of(mesh, metric, *L, bending, regions);
    std::vector<bool> held(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v)
        held[v] = !regions.is_free(v);
    progress.tick(0.1, "factorising");
    ConstrainedSystem harmonic;
    HandleFields fields;
    harmonic.factorize(std::move(L), regions, [&] {
        progress.tick(0.4, "computing the fields");
        fields = HandleFields(HandleGroups(regions, connected_components(mesh)), regions, harmonic);
        progress.tick(0.6, "factorising");
    });
    BindReport of_fields;
    harmonic.report(of_fields);
    RowSystem cells(rows, mesh.points(), held, held);
    const std::int64_t bytes = std::max(of_fields.factor_bytes, 2 * cells.factor_bytes());
    return std::unique_ptr<const Binding>(
        new Binding{unit, bytes, std::move(fields), std::move(cells), handle_patches(mesh, regions), {}});
}

} // namespace

struct MeshPuppetry::Impl
{
    double unit = 1.0; ///< see normal_unit()
    int factorizations = 0;
    std::unique_ptr<const Binding> bound; ///< null before the first bind
};

MeshPuppetry::MeshPuppetry(const SurfaceMesh& rest, const MeshPuppetryOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    impl_->unit = normal_unit(rest.points());
}

void MeshPuppetry::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const std::optional<SurfaceMesh> scaled = in_unit(rest(), self.unit);
    const SurfaceMesh& mesh = scaled ? *scaled : rest();
    auto next = bound(mesh, self.unit, regions, options().bending, progress);
    progress.tick(1.0, "bound");
    self.bound = std::move(next);
    self.factorizations += 2;
    report.degenerate_faces = degenerate_face_count(mesh);
    report.factorizations = self.factorizations;
    report.factor_bytes = self.bound->factor_bytes;
}

SolveReport MeshPuppetry::deform(const SolveRequest& request, const Targets& targets, Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const RowSystem& cells = bound.cells;
    const int n = cells.point_count();
    const double scale = 1.0 / bound.unit;
    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    const PointsView base = targets.base();

    positions = base;
    parallel_for(n, [&](int v) {
        if (const int handle = regions().hard(v); handle >= 0)
            positions.row(v) = targets.position(v, handle).transpose();
    });
    std::vector<Matrix3> turns = linear_maps(targets, bound.patches);
    for (Matrix3& turn : turns)
        turn = Polar(turn).R;
    const HandleGroups& groups = bound.fields.groups();
    const MapBlend blend(groups, turns);
    SolveReport report{.converged = true, .half_turns = blend.half_turns(groups)};
    if (cells.free_count() == 0)
        return report;

    work->held = scale * positions;
    work->pulls.resize(static_cast<Eigen::Index>(regions().soft().size()), 3);
    for (std::size_t k = 0; k < regions().soft().size(); ++k) {
        const SoftConstraint& soft = regions().soft()[k];
        work->pulls.row(static_cast<Eigen::Index>(k)) =
            scale * targets.position(soft.vertex, soft.handle).transpose();
    }
    const RotationVectors* vectors = &cells.rest_vectors();
    if (targets.incoming) {
        work->base = scale * base;
        cells.set_vectors(view(work->base), work->vectors);
        vectors = &work->vectors;
    }
    RowProblem problem(cells, *vectors, work->held, work->pulls, &work->buffers);
    work->blended.resize(n, MapBlend::numbers);
    bound.fields.blend(blend.values(), work->blended);
    parallel_for(n, [&](int v) {
        Matrix3 turn = Matrix3::Identity();
        if (const int handle = regions().hard(v); handle >= 0)
            turn = turns[handle];
        else if (const int group = groups.group[v]; group >= 0)
            for (int axis = 0; axis < 3; ++axis)
                turn.col(axis) = blend.at(group, work->blended.row(v).data())(Vector3::Unit(axis));
        problem.set_rotation(v, turn);
    });
    if (request.start) {
        work->base = scale * *request.start;
        work->x = cells.free_rows(view(work->base));
    } else {
        problem.global_step(work->x);
    }
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(this->options().max_iterations),
                         .tolerance = request.tolerance.value_or(this->options().tolerance),
                         .floor = rounding_floor * cells.scale(*vectors)};
    const int half_turns = report.half_turns;
    report = minimize(problem, work->x, options, request.progress, &work->descent);
    report.half_turns = half_turns;
    report.energy *= bound.unit * bound.unit;
    problem.place(work->x, work->base);
    parallel_for(n, [&](int v) {
        if (regions().is_free(v))
            positions.row(v) = bound.unit * work->base.row(v);
    });
    return report;
}

void MeshPuppetry::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<MeshPuppetry&>(other).impl_;
    std::swap(impl_->factorizations, others.factorizations);
    std::swap(impl_->bound, others.bound);
}

} // namespace sinew
