// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/subspace_laplacian.h"

#include "native/caging/cage_diagnosis.h"
#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/progress_part.h"
#include "native/handles/constrained_system.h"
#include "native/handles/handle_fields.h"
#include "native/local_global/graph/clusters.h"
#include "native/local_global/reduced/subspace_cells.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/methods/surface/nonlinear/subspace/caged_part.h"
#include "native/operators/laplacian.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>

namespace sinew {

namespace {

constexpr double held_stiffness = 1e5; ///< of all held vertices of a handle together
constexpr double fade = 0.04;          ///< over which the gap at a handle fades, as a share of the size
/// From this weight on, a vertex turns with its handle, and the gap is put right the more.
constexpr double firm = 0.9;
/// An energy below this share of that of all edges is rounding.
constexpr double rounding_floor = 1e-14;

GraphEdges edges_of(const SparseMatrix& L, const std::vector<int>& vertices, const std::vector<int>& places)
{
    GraphEdges edges;
    for (const int v : vertices) {
        for (SparseMatrix::InnerIterator it(L, v); it; ++it)
            if (it.row() != v) {
                edges.neighbours.push_back(places[it.row()]);
                edges.weights.push_back(std::max(-it.value(), 1e-300));
            }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }
    return edges;
}

/// A part with its handles.
struct Part
{
    std::shared_ptr<const CagedPart> space;
    std::vector<int> handles; ///< of its part handles
    std::unique_ptr<const SubspaceCells> cells;
    SubspaceCells::Base base; ///< the rest shape
    RowMatrix shares;         ///< (clusters, part handles) the means of the fields
    std::unique_ptr<const ClusterMap> map;
    struct Near
    {
        int vertex, handle;
        double share; ///< 1 on the handle
    };
    std::vector<Near> near; ///< vertices that the gap at a handle moves
    double floor = 0.0;     ///< of the energy
    double unit = 1.0; ///< of the unknowns, whose steps are kept in single precision
};

/// How far the gap is put right at a vertex of a weight: in [0, 1], smooth, and 1 only where it is held.
double grip_of(double weight)
{
    const double t = std::max(0.0, (weight - firm) / (1.0 - firm));
    return t * t * (3 - 2 * t);
}

/// The vertices within a distance of the firm ones along the edges, and the handle that is nearest.
/// \param grips  grip_of() each.
std::vector<Part::Near> near_handles(const GraphEdges& edges, const CagedPart& space,
                                     const std::vector<int>& hard, std::vector<double> grips)
{
    const double width = fade * space.size;
    std::vector<double> distance(hard.size(), std::numeric_limits<double>::infinity());
    std::vector<int> handle = hard;
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
    for (std::size_t v = 0; v < hard.size(); ++v)
        if (hard[v] >= 0) {
            distance[v] = 0.0;
            front.emplace(0.0, static_cast<int>(v));
        }
    std::vector<Part::Near> near;
    while (!front.empty()) {
        const auto [d, v] = front.top();
        front.pop();
        if (d > distance[v])
            continue;
        const double t = width > 0 ? 1.0 - d / width : 1.0;
        near.push_back({v, handle[v], grips[v] * t * t * (3 - 2 * t)});
        for (int a = edges.offsets[v]; a < edges.offsets[v + 1]; ++a) {
            const int j = edges.neighbours[a];
            const double further = d + (space.rest.row(v) - space.rest.row(j)).norm();
            if (further < distance[j] && further < width) {
                distance[j] = further;
                handle[j] = handle[v];
                grips[j] = grips[v];
                front.emplace(further, j);
            }
        }
    }
    return near;
}

/// Balls around the connected vertices of equal handles.
std::vector<Detail> balls_around_held(const GraphEdges& edges, const Points& rest,
                                      const std::vector<int>& hard)
{
    std::vector<Detail> balls;
    std::vector<char> seen(hard.size(), 0);
    for (std::size_t v = 0; v < hard.size(); ++v) {
        if (hard[v] < 0 || std::exchange(seen[v], 1))
            continue;
        std::vector<int> piece{static_cast<int>(v)};
        for (std::size_t k = 0; k < piece.size(); ++k)
            for (int a = edges.offsets[piece[k]]; a < edges.offsets[piece[k] + 1]; ++a)
                if (const int j = edges.neighbours[a]; hard[j] == hard[v] && !std::exchange(seen[j], 1))
                    piece.push_back(j);
        const Points points = rest(piece, Eigen::all);
        const Eigen::RowVector3d centre = points.colwise().mean();
        balls.push_back({centre.transpose(), (points.rowwise() - centre).rowwise().norm().maxCoeff()});
    }
    return balls;
}

struct Binding
{
    std::vector<Part> parts;
    std::vector<int> idle;
    std::vector<int> clusters; ///< (n) over all parts; -1 in parts without a handle
};

struct Frame
{
    Points incoming, left, moved, shape, moves;
    LbfgsWorkspace descent;
};

Points posed(const Pose& pose, const Points& points)
{
    return (points * pose.leftCols<3>().transpose()).rowwise() + pose.col(3).transpose();
}

} // namespace

struct SubspaceLaplacian::Impl
{
    explicit Impl(const SubspaceLaplacianOptions& given) : options(given) {}

    const SubspaceLaplacianOptions& options;
    std::optional<SurfaceMesh> cage;
    struct Space
    {
        std::vector<Detail> details; ///< that its cage is made for
        std::shared_ptr<const CagedPart> part;
    };
    std::map<int, Space> spaces; ///< by the lowest vertices of their parts
    ConstrainedSystem system;                                     ///< of the Laplacian, for the fields
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
    mutable Pool<Frame> frames;

    std::shared_ptr<const CagedPart> space_of(const SurfaceMesh& mesh, const std::vector<int>& vertices,
                                              const GraphEdges& edges, const std::vector<int>& hard,
                                              const Progress& progress);
    void refuse_outside(const SurfaceMesh& mesh, const HandleGroups& groups) const;
    SolveReport solve(const Part& part, const SolveRequest& request, const Targets& targets, Frame& frame,
                      Points& positions) const;
};

std::shared_ptr<const CagedPart> SubspaceLaplacian::Impl::space_of(const SurfaceMesh& mesh,
                                                                   const std::vector<int>& vertices,
                                                                   const GraphEdges& edges,
                                                                   const std::vector<int>& hard,
                                                                   const Progress& progress)
{
    auto& [known, part] = spaces[vertices.front()];
    std::vector<Detail> details;
    if (!cage && options.cage_faces == 0)
        details = balls_around_held(edges, mesh.points()(vertices, Eigen::all), hard);
    if (!part || known != details) {
        part = std::make_shared<const CagedPart>(mesh, vertices, edges, cage, options.cage_faces, details,
                                                 progress);
        known = std::move(details);
    }
    return part;
}

void SubspaceLaplacian::Impl::refuse_outside(const SurfaceMesh& mesh, const HandleGroups& groups) const
{
    std::vector<int> driven, outside;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (groups.group[v] >= 0)
            driven.push_back(v);
    const Points points = mesh.points()(driven, Eigen::all);
    for (const int k : diagnose_cage(*cage, view(points)).outside_points)
        outside.push_back(driven[k]);
    if (!outside.empty())
        throw InvalidConstraint("cage: vertices " + list_some(outside) +
                                    " are outside of it; enlarge the cage there, or leave it to Sinew",
                                Error::Element::vertex, outside);
}

SubspaceLaplacian::SubspaceLaplacian(const SurfaceMesh& rest, const SubspaceLaplacianOptions& options,
                                     std::optional<SurfaceMesh> cage)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>(this->options()))
{
    if (options.cage_faces != 0 && options.cage_faces < 12)
        throw InvalidOption("cage_faces: " + std::to_string(options.cage_faces) +
                            " is neither 0 nor in 12 to 2,000; each face costs every vertex a weight");
    if (cage)
        (void)Cage(*cage);
    impl_->cage = std::move(cage);
}

void SubspaceLaplacian::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const int n = rest().vertex_count();
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), Discretization::cotan, metric));
    make_weights_positive(*L);
    const VectorX diagonal = L->diagonal();
    const VectorX mass = divisible_mass(rest(), Discretization::cotan_voronoi, metric);
    const HandleGroups groups(regions, connected_components(rest()));
    if (self.cage && groups.count() > 0)
        self.refuse_outside(rest(), groups);
    std::vector<std::vector<int>> members(groups.count());
    std::vector<int> places(n, -1);
    std::vector<double> areas(groups.count(), 0.0);
    auto next = std::make_unique<Binding>();
    next->clusters.assign(n, -1);
    for (int v = 0; v < n; ++v) {
        if (groups.group[v] < 0) {
            next->idle.push_back(v);
            continue;
        }
        places[v] = static_cast<int>(members[groups.group[v]].size());
        members[groups.group[v]].push_back(v);
    }
    for (std::size_t t = 0; t < rest().triangles().size(); ++t)
        if (const int g = groups.group[rest().triangles()[t][0]]; g >= 0)
            areas[g] += metric.area[t];
    progress.tick(0.1, "factorising");
    self.system.factorize(std::move(L), regions, [&] {
        progress.tick(0.3, "computing the fields");
        const HandleFields fields(groups, regions, self.system);
        const SparseMatrix& matrix = self.system.matrix();
        for (int g = 0; g < groups.count(); ++g) {
            const double begin = 0.3 + 0.7 * g / groups.count(), share = 0.7 / groups.count();
            Part& part = next->parts.emplace_back();
            part.handles.assign(groups.handles.begin() + groups.offsets[g],
                                groups.handles.begin() + groups.offsets[g + 1]);
            const GraphEdges edges = edges_of(matrix, members[g], places);
            const auto count = static_cast<int>(members[g].size());

            std::vector<int> hard(count);
            VectorX own_mass(count);
            std::vector<double> grips(count, 1.0);
            std::vector<int> held(groups.part_handle_count(), 0);
            for (int k = 0; k < count; ++k) {
                hard[k] = regions.hard(members[g][k]);
                own_mass[k] = mass[members[g][k]];
                if (hard[k] >= 0)
                    ++held[groups.part_handle({members[g][k], hard[k]})];
            }
            for (const SoftConstraint& soft : regions.soft())
                if (groups.group[soft.vertex] == g) {
                    ++held[groups.part_handle({soft.vertex, soft.handle})];
                    if (soft.weight > firm) {
                        hard[places[soft.vertex]] = soft.handle;
                        grips[places[soft.vertex]] = grip_of(soft.weight);
                    }
                }
            part.space =
                self.space_of(rest(), members[g], edges, hard, part_of(progress, begin, begin + 0.6 * share));
            progress.tick(begin + 0.6 * share, "gathering the energy");
            const CagedPart& space = *part.space;
            std::vector<SubspaceCells::Pull> pulls;
            const int first = groups.offsets[g];
            for (int k = 0; k < count; ++k)
                if (const int handle = regions.hard(members[g][k]); handle >= 0) {
                    const int part_handle = groups.part_handle({members[g][k], handle});
                    pulls.push_back({part_handle - first, k, held_stiffness / held[part_handle]});
                }
            for (const SoftConstraint& soft : regions.soft())
                if (groups.group[soft.vertex] == g) {
                    const double unit = diagonal[soft.vertex] > 0 ? diagonal[soft.vertex] : 1.0;
                    const int part_handle = groups.part_handle({soft.vertex, soft.handle});
                    pulls.push_back({part_handle - first, places[soft.vertex],
                                     std::min(soft.stiffness() * unit, held_stiffness / held[part_handle])});
                }
            part.near = near_handles(edges, space, hard, std::move(grips));
            const Clusters clusters = clusters_of(edges, space.rest, hard, self.options.clusters);
            const auto cluster_count = static_cast<int>(clusters.seeds.size());
            const int so_far = *std::ranges::max_element(next->clusters) + 1;
            for (int k = 0; k < count; ++k)
                next->clusters[members[g][k]] = so_far + clusters.label[k];
            GraphHandles none;
            none.hard.assign(count, -1);
            none.idle.assign(count, 0);
            part.map = std::make_unique<const ClusterMap>(HandleGraph(edges, std::move(none)), clusters);
            const auto part_handles = static_cast<Eigen::Index>(part.handles.size());
            part.shares = RowMatrix::Zero(cluster_count, part_handles);
            VectorX sizes = VectorX::Zero(cluster_count);
            for (int k = 0; k < count; ++k) {
                sizes[clusters.label[k]] += 1.0;
                for (Eigen::Index s = 0; s < part_handles; ++s)
                    part.shares(clusters.label[k], s) +=
                        fields.share(members[g][k], first + static_cast<int>(s));
            }
            part.shares = (sizes.cwiseInverse().asDiagonal() * part.shares).eval();
            const RowMatrix B = space.exact_weights();
            require_memory(static_cast<std::int64_t>(sizeof(double)) * B.cols() * B.cols() *
                               (cluster_count + static_cast<std::int64_t>(part_handles) + 2),
                           "the energy of the cage");
            SparseMatrix own(count, count);
            {
                std::vector<Eigen::Triplet<double>> entries;
                for (int k = 0; k < count; ++k)
                    for (int a = edges.offsets[k]; a < edges.offsets[k + 1]; ++a)
                        entries.emplace_back(edges.neighbours[a], k, -edges.weights[a]);
                own.setFromTriplets(entries.begin(), entries.end());
            }
            part.cells = std::make_unique<const SubspaceCells>(B, own, own_mass, clusters.label,
                                                               cluster_count, self.options.bending * areas[g],
                                                               pulls, static_cast<int>(part_handles));
            part.unit = normal_unit(rest().points());
            part.base = part.cells->base(space.y / part.unit);
            double scale = 0.0;
            for (int k = 0; k < cluster_count; ++k)
                scale += part.base.own.middleRows<3>(3 * k).trace();
            part.floor = rounding_floor * scale;
        }
        progress.tick(1.0, "bound");
    });
    self.bound = std::move(next);
    self.system.report(report);
    for (const Part& part : self.bound->parts)
        report.factor_bytes += part.cells->bytes() + part.space->weights().bytes();
}

SolveReport SubspaceLaplacian::Impl::solve(const Part& part, const SolveRequest& request,
                                           const Targets& targets, Frame& frame, Points& positions) const
{
    const CagedPart& space = *part.space;
    const auto n = static_cast<int>(space.vertices.size());
    const bool enters = targets.incoming.has_value();
    const PointsView given = targets.base();
    SubspaceCells::Base other;
    if (enters) {
        frame.incoming.resize(n, 3);
        parallel_for(n, [&](int k) { frame.incoming.row(k) = given.row(space.vertices[k]); });
        const Points change = space.means(frame.incoming - space.rest);
        const Points moves = space.projection.solve(transposed_product(space.coarse, change));
        other = part.cells->base((space.y + moves) / part.unit);
        frame.moves = -moves;
        frame.moved = frame.incoming - space.rest;
        frame.left.resize(n, 3);
        space.weights().apply(frame.moves, view(frame.moved), frame.left.data());
    }
    const SubspaceCells::Base& base = enters ? other : part.base;
    const Points& shape = enters ? frame.incoming : space.rest;

    Poses poses;
    const Points at_base = part.unit * base.y;
    const Vector3 centre = at_base.colwise().mean().transpose();
    for (const int handle : part.handles) {
        Pose about = targets.poses[handle];
        about.col(3) = apply(about, centre);
        poses.push_back(about);
    }
    Pose mean = rigid_mean(poses);
    const std::vector<Matrix3> starts = mean_rotations(part.shares, poses, mean.leftCols<3>());
    mean.col(3) -= mean.leftCols<3>() * centre;
    const Points resting = posed(mean, at_base);
    std::vector<Points> aims;
    for (const int handle : part.handles) {
        const bool from_rest = targets.from_rest && (*targets.from_rest)[handle];
        aims.emplace_back((posed(targets.poses[handle], from_rest ? space.y : at_base) - resting) /
                          part.unit);
    }
    const bool keeps = options.keep_volume && space.has_volume;
    Points coarse;
    if (keeps)
        coarse = posed(mean, enters ? space.means(shape) : space.coarse_rest) / part.unit;
    SubspaceProblem problem(*part.cells, base, mean, aims, keeps ? &space.coarse_volume : nullptr, coarse);
    for (int k = 0; k < part.cells->cluster_count(); ++k)
        problem.set_rotation(k, starts[k]);
    Points u = problem.unknowns_for_rotations();
    SolveReport report = minimize(problem, u,
                                  {.max_iterations = request.max_iterations.value_or(options.max_iterations),
                                   .tolerance = request.tolerance.value_or(options.tolerance),
                                   .floor = part.floor,
                                   .plain_steps = 4},
                                  request.progress, &frame.descent);

    u *= part.unit;
    report.energy *= part.unit * part.unit;

    const Matrix3 turn = mean.leftCols<3>() - Matrix3::Identity();
    frame.moved.resize(n, 3);
    frame.shape.resize(n, 3);
    parallel_for(n, [&](int k) {
        const Vector3 p = shape.row(k).transpose();
        Vector3 to = p + (turn * p + mean.col(3));
        if (enters) { // what the cage cannot show turns with the clusters around it
            const ClusterMap::Shares shares = part.map->shares(k);
            for (int i = 0; i < shares.count; ++i)
                to += shares.weights[i] *
                      (frame.left.row(k) * problem.turns().middleRows<3>(3 * shares.clusters[i])).transpose();
        }
        frame.moved.row(k) = to.transpose();
    });
    space.weights().apply(u, view(frame.moved), frame.shape.data());
    for (const auto& [vertex, handle, share] : part.near) {
        const Vector3 aim = targets.position(space.vertices[vertex], handle);
        if (share == 1.0)
            frame.shape.row(vertex) = aim.transpose();
        else
            frame.shape.row(vertex) += share * (aim.transpose() - frame.shape.row(vertex));
    }
    if (keeps) {
        Points& direction = frame.left;
        frame.moves = problem.volume_direction();
        frame.moved.setZero(n, 3);
        direction.resize(n, 3);
        space.weights().apply(frame.moves, view(frame.moved), direction.data());
        for (const auto& [vertex, handle, share] : part.near)
            direction.row(vertex) *= 1.0 - share;
        const double wanted = enters ? space.volume.of(view(shape)) : space.rest_volume;
        if (const auto step = space.volume.step(view(frame.shape), view(direction), wanted))
            parallel_for(n, [&](int k) { frame.shape.row(k) += *step * direction.row(k); });
    }
    parallel_for(n, [&](int k) { positions.row(space.vertices[k]) = frame.shape.row(k); });
    return report;
}

SolveReport SubspaceLaplacian::deform(const SolveRequest& request, const Targets& targets,
                                      Points& positions) const
{
    const Binding& bound = *impl_->bound;
    positions.resize(rest().vertex_count(), 3);
    for (const int v : bound.idle)
        positions.row(v) = targets.base().row(v);
    const auto frame = impl_->frames.take([] { return std::make_unique<Frame>(); });
    SolveReport report{.converged = true};
    for (const Part& part : bound.parts) {
        const SolveReport own = impl_->solve(part, request, targets, *frame, positions);
        report.iterations = std::max(report.iterations, own.iterations);
        report.rejected += own.rejected;
        report.energy += own.energy;
        report.residual = std::max(report.residual, own.residual);
        report.converged = report.converged && own.converged;
    }
    return report;
}

std::vector<SurfaceMesh> SubspaceLaplacian::cages() const
{
    const AccessLock shared = reading();
    std::vector<SurfaceMesh> cages;
    for (const Part& part : impl_->bound->parts)
        if (part.space->cage)
            cages.push_back(*part.space->cage);
    return cages;
}

std::vector<int> SubspaceLaplacian::clusters() const
{
    const AccessLock shared = reading();
    return impl_->bound->clusters;
}

std::vector<std::string> SubspaceLaplacian::changed_options(const SurfaceMethod& former) const
{
    const auto& other = static_cast<const SubspaceLaplacian&>(former);
    return changed(options(), other.options(), names_of({{"cage", !(impl_->cage == other.impl_->cage)}}));
}

void SubspaceLaplacian::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<SubspaceLaplacian&>(other).impl_;
    std::swap(impl_->spaces, others.spaces);
    std::swap(impl_->system, others.system);
    std::swap(impl_->bound, others.bound);
}

} // namespace sinew
