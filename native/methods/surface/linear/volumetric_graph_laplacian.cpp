// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/volumetric_graph_laplacian.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/handles/constrained_system.h"
#include "native/handles/handle_fields.h"
#include "native/handles/map_blend.h"
#include "native/methods/surface/linear/volume/volume_graph.h"
#include "native/operators/differential_coordinates.h"
#include "native/solvers/smallest_factor.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

constexpr double shortest = 1e-3; ///< of an edge of the graph, in mean edges

/// The graph with the numbers that depend on the rest shape alone.
struct Inside
{
    VolumeGraph graph;
    bool filled;         ///< whether points inside were asked for
    Points points;       ///< (n + g, 3) of all nodes
    Components parts;    ///< of all nodes
    SparseMatrix conductance; ///< (n + g, n + g) the Laplacian of the graph for the fields
    SparseMatrix rows;   ///< (n + g, n + g) D^T: column i has row i of D
    SparseMatrix D;

    /// \param fill  whether there are points inside.
    Inside(const SurfaceMesh& mesh, bool fill, const Progress& progress) : filled(fill)
    {
        const Components own = connected_components(mesh);
        if (fill)
            graph = volume_graph(mesh, own, progress);
        else
            graph.points.resize(0, 3);
        const int n = mesh.vertex_count(), nodes = n + graph.count();
        points.resize(nodes, 3);
        points << mesh.points(), graph.points;
        parts = own;
        parts.labels.insert(parts.labels.end(), graph.parts.begin(), graph.parts.end());
        const auto weight = [&](const std::array<int, 2>& edge) {
            const double unit = graph.mean_edges[parts.labels[edge[0]]];
            return unit / std::max(shortest * unit, (points.row(edge[0]) - points.row(edge[1])).norm());
        };
        std::vector<Eigen::Triplet<double>> entries;
        for (const auto& edge : graph.edges) {
            const double w = weight(edge);
            entries.emplace_back(edge[0], edge[1], -w);
            entries.emplace_back(edge[1], edge[0], -w);
            entries.emplace_back(edge[0], edge[0], w);
            entries.emplace_back(edge[1], edge[1], w);
        }
        conductance.resize(nodes, nodes);
        conductance.setFromTriplets(entries.begin(), entries.end());
        rows = conductance; // symmetric
        for (int i = 0; i < nodes; ++i) {
            const double sum = conductance.coeff(i, i);
            for (SparseMatrix::InnerIterator it(rows, i); it; ++it)
                it.valueRef() /= sum;
        }
        D = rows.transpose();
    }

    int nodes() const { return static_cast<int>(points.rows()); }

    /// (n + g) alpha / mean mass of the part.
    VectorX weights(double alpha, const VectorX& mass) const
    {
        VectorX sums = VectorX::Zero(parts.count), counts = sums, weights(nodes());
        for (int v = 0; v < static_cast<int>(mass.size()); ++v) {
            sums[parts.labels[v]] += mass[v];
            ++counts[parts.labels[v]];
        }
        for (int i = 0; i < nodes(); ++i)
            weights[i] = alpha * counts[parts.labels[i]] / sums[parts.labels[i]];
        return weights;
    }

    /// The Laplacian of the surface, with positive weights, and of the graph.
    SparseMatrix conductance_with(SparseMatrix L) const
    {
        make_weights_positive(L);
        const int n = static_cast<int>(L.cols());
        return sparse_by_columns(nodes(), nodes(), [&](int c, SparseColumn& column) {
            if (c < n)
                for (SparseMatrix::InnerIterator it(L, c); it; ++it)
                    column.add(static_cast<int>(it.row()), it.value());
            for (SparseMatrix::InnerIterator it(conductance, c); it; ++it)
                column.add(static_cast<int>(it.row()), it.value());
        });
    }

    /// D p.
    void differentiate(const PointsView& p, Points& delta) const
    {
        delta.resize(nodes(), 3);
        parallel_for(nodes(), [&](int i) { delta.row(i) = laplacian_at(rows, p, i).transpose(); });
    }
};

/// The workspace of a frame.
struct Workspace
{
    Points base;              ///< (n + g, 3) the incoming shape, with the points inside
    Points delta, inner;      ///< its M^-1 L y and D y
    RowMatrix change, change_inside; ///< T delta - delta; zero where no handle touches the part
    RowMatrix nine;           ///< (n + g, 9) blended maps
    Points positions;         ///< (n + g, 3)
};

struct Binding
{
    ConstrainedSystem system{{.ordering = smallest_factor()}};
    ConstrainedSystem poisson;
    std::shared_ptr<const Inside> inside; ///< null before the first bind
    SparseMatrix L;
    VectorX mass;
    VectorX weights;     ///< (n + g) alpha / mean mass of the part
    Points delta, inner; ///< of the rest shape
    HandleFields fields; ///< at all nodes
    HandleGroups groups; ///< of the vertices
    std::vector<std::vector<int>> patches;
    mutable Pool<Workspace> workspaces;
};

/// (n + g, n + g) L M^-1 L + D^T W D.
SparseMatrix system_matrix(const SparseMatrix& L, const VectorX& mass, const Inside& inside,
                           const VectorX& weights)
{
    const int n = static_cast<int>(mass.size());
    const bool has_volume = weights.maxCoeff() > 0;
    return sparse_by_columns(inside.nodes(), inside.nodes(), [&](int c, SparseColumn& column) {
        if (c < n)
            for (SparseMatrix::InnerIterator b(L, c); b; ++b)
                for (SparseMatrix::InnerIterator a(L, static_cast<int>(b.row())); a; ++a)
                    column.add(static_cast<int>(a.row()), a.value() * b.value() / mass[b.row()]);
        if (!has_volume)
            return;
        for (SparseMatrix::InnerIterator b(inside.D, c); b; ++b)
            for (SparseMatrix::InnerIterator a(inside.rows, static_cast<int>(b.row())); a; ++a)
                column.add(static_cast<int>(a.row()), weights[b.row()] * (a.value() * b.value()));
    });
}

} // namespace

struct VolumetricGraphLaplacian::Impl
{
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

VolumetricGraphLaplacian::VolumetricGraphLaplacian(const SurfaceMesh& rest,
                                                   const VolumetricGraphLaplacianOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
}

Points VolumetricGraphLaplacian::inner_points() const
{
    const AccessLock shared = reading();
    const auto& inside = impl_->bound->inside;
    return inside ? inside->graph.points : Points(0, 3);
}

std::vector<std::array<int, 2>> VolumetricGraphLaplacian::graph_edges() const
{
    const AccessLock shared = reading();
    const auto& inside = impl_->bound->inside;
    return inside ? inside->graph.edges : std::vector<std::array<int, 2>>();
}

void VolumetricGraphLaplacian::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const double alpha = options().volume;
    const int n = rest().vertex_count();
    std::shared_ptr<const Inside> inside = bound.inside;
    if (!inside || inside->filled != (alpha > 0))
        inside = std::make_shared<Inside>(rest(), alpha > 0, progress);
    progress.tick(0.1, "assembling");
    SparseMatrix L;
    VectorX mass;
    {
        const TriangleMetric metric = triangle_metric(rest(), least_area_for_order(2));
        report.degenerate_faces = degenerate_face_count(rest(), metric);
        L = laplacian_matrix(rest(), options().laplacian, metric);
        mass = divisible_mass(rest(), options().laplacian, metric);
    }
    VectorX weights = inside->weights(alpha, mass);
    Points delta, inner;
    differentiate(L, mass, view(rest().points()), delta);
    inside->differentiate(view(inside->points), inner);
    // The points inside are free vertices of the parts around them.
    const Regions all(regions.handles(), inside->parts);
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    HandleFields fields;
    progress.tick(0.15, "factorising");
    try {
        bound.system.factorize(
            std::make_shared<SparseMatrix>(system_matrix(L, mass, *inside, weights)), all, [&] {
                progress.tick(0.8, "preparing the transformations");
                bound.poisson.factorize(std::make_shared<SparseMatrix>(inside->conductance_with(L)), all);
                fields = HandleFields(HandleGroups(all, inside->parts), all, bound.poisson);
                progress.tick(1.0, "bound");
            });
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty() || failure.elements().front() < n)
            throw;
        const int vertex = inside->graph.nearby[failure.elements().front() - n];
        throw FactorizationFailed("the system is singular; it broke down inside vertex " +
                                      std::to_string(vertex),
                                  Error::Element::vertex, {vertex});
    }
    bound.groups = HandleGroups(regions, connected_components(rest()));
    bound.inside = std::move(inside);
    bound.fields = std::move(fields);
    bound.patches = std::move(patches);
    bound.L.swap(L); // the move assignment of Eigen's sparse matrices would copy
    bound.mass = std::move(mass);
    bound.weights = std::move(weights);
    bound.delta = std::move(delta);
    bound.inner = std::move(inner);
    bound.workspaces.clear(); // idle rows stay zero
    bound.system.report(report);
    BindReport of_fields;
    bound.poisson.report(of_fields);
    report.factorizations += of_fields.factorizations;
    report.analyses += of_fields.analyses;
    report.factor_bytes += of_fields.factor_bytes;
}

SolveReport VolumetricGraphLaplacian::deform(const SolveRequest& /*request*/, const Targets& targets,
                                             Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const Inside& inside = *bound.inside;
    const int n = rest().vertex_count(), nodes = inside.nodes();
    const auto work = bound.workspaces.take([&] {
        auto made = std::make_unique<Workspace>();
        made->change = RowMatrix::Zero(n, 3);
        made->change_inside = RowMatrix::Zero(nodes, 3);
        made->nine.resize(nodes, MapBlend::numbers);
        return made;
    });
    Targets all{targets.poses, view(inside.points), std::nullopt, targets.from_rest};
    if (targets.incoming) {
        work->base.resize(nodes, 3);
        work->base.topRows(n) = *targets.incoming;
        inside.graph.attachments.move(std::nullopt, work->base);
        all.incoming.emplace(view(work->base));
        differentiate(bound.L, bound.mass, *targets.incoming, work->delta);
        inside.differentiate(view(work->base), work->inner);
    }
    const Points &delta = targets.incoming ? work->delta : bound.delta,
                 &inner = targets.incoming ? work->inner : bound.inner;
    const HandleGroups& groups = bound.fields.groups();
    const MapBlend blend(groups, linear_maps(targets, bound.patches));
    bound.fields.blend(blend.values(), work->nine);
    SolveReport report = bound.system.solve(all, work->positions, [&](RowMatrix& b) {
        const double sum = parallel_sum(nodes, [&](int k) {
            if (groups.group[k] < 0)
                return 0.0;
            const MapBlend::Map T = blend.at(
                groups.group[k], work->nine.data() + MapBlend::numbers * static_cast<std::ptrdiff_t>(k));
            const auto changed = [&](const Points& of, RowMatrix& change, double weight) {
                const Vector3 before = of.row(k).transpose(), by = T(before) - before;
                change.row(k) = by.transpose();
                return weight * by.squaredNorm();
            };
            return (k < n ? changed(delta, work->change, bound.mass[k]) : 0.0) +
                   changed(inner, work->change_inside, bound.weights[k]);
        });
        parallel_for(nodes, [&](int k) {
            Vector3 row = k < n ? laplacian_at(bound.L, work->change, k) : Vector3(0, 0, 0);
            for (SparseMatrix::InnerIterator it(inside.D, k); it; ++it)
                row += bound.weights[it.row()] * it.value() * work->change_inside.row(it.row()).transpose();
            b.row(k) = row.transpose();
        });
        return sum;
    });
    positions = work->positions.topRows(n);
    report.half_turns = blend.half_turns(bound.groups);
    return report;
}

void VolumetricGraphLaplacian::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<VolumetricGraphLaplacian&>(other).impl_->bound);
}

} // namespace sinew
