// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/embedded_deformation.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/methods/space/nonlinear/graph/deformation_graph.h"
#include "native/methods/space/nonlinear/graph/embedded_energy.h"
#include "native/methods/space/nonlinear/handles/handle_reach.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// Of the energy per node: what rounding leaves of it, and what moves nothing by more than 1e-9 of an edge.
constexpr double rounding_floor = 1e-20;
constexpr int most_alone = 2;            ///< a handle of so few points says too little about its rotation
constexpr double side_strength = 0.5;

/// The points that handles pull, in units of the edges, and how.
struct Pulls
{
    std::vector<EmbeddedEnergy::Pull> pulls;
    std::vector<int> points;          ///< of each pull, the point of the handles, or c and the node
    std::vector<Vector3> sides;       ///< and how far beside it
};

/// \param holding  (c) as holds() says it.
/// \param pieces   (m) that of each node. The nodes of those that no handle pulls become points that are
///                 numbered from c on, and are pulled by the handle that rests.
Pulls pulls_of(const HandlePoints& held, const std::vector<HandleReach::Shares>& shares,
               const std::vector<double>& holding, const std::vector<int>& pieces)
{
    const auto weight = [&](int p) { return held.weight(p) * holding[p]; };
    std::vector<double> density(pieces.size(), 0.0);
    std::vector<char> is_pulled(pieces.size(), 0);
    for (int p = 0; p < static_cast<int>(shares.size()); ++p)
        for (const auto& share : shares[p]) {
            density[share.map] += weight(p) * share.weight;
            is_pulled[pieces[share.map]] |= weight(p) > 0.0;
        }
    Pulls result;
    for (int p = 0; p < static_cast<int>(shares.size()); ++p) {
        if (weight(p) == 0.0)
            continue;
        double strength = 0.0;
        for (const auto& share : shares[p])
            strength += share.weight * std::min(1.0, 1.0 / density[share.map]);
        strength *= weight(p);
        const int handle = held.handle_of(p);
        const auto add = [&](const Vector3& side, double share) {
            result.pulls.push_back({handle, share * strength, shares[p]});
            result.points.push_back(p);
            result.sides.push_back(side);
        };
        add(Vector3::Zero(), 1.0);
        if (held.count(handle) <= most_alone)
            for (int axis = 0; axis < 3; ++axis)
                for (const double side : {1.0, -1.0})
                    add(side * Vector3::Unit(axis), side_strength);
    }
    for (int j = 0; j < static_cast<int>(pieces.size()); ++j)
        if (!is_pulled[pieces[j]]) {
            result.pulls.push_back({held.handle_count(), 1.0, {{j, 1.0}}});
            result.points.push_back(held.point_count() + j);
            result.sides.push_back(Vector3::Zero());
        }
    return result;
}

LbfgsOptions descent(int max_iterations, double tolerance, Eigen::Index nodes)
{
    return {.max_iterations = max_iterations,
            .tolerance = tolerance,
            .floor = rounding_floor * static_cast<double>(nodes),
            .plain_steps = 4};
}

} // namespace

struct EmbeddedDeformation::Binding
{
    Points nodes; ///< (m, 3)
    std::vector<std::array<int, 2>> edges;
    double edge; ///< the mean edge of the graph, in the units of the motions
    Pulls pulls;
    EmbeddedEnergy energy;
    BlendedMaps points;
    std::vector<int> node_carriers, handle_carriers; ///< bound points; empty without any
    mutable Pool<Workspace> workspaces;
};

struct EmbeddedDeformation::Workspace
{
    LbfgsWorkspace descent;
    Points x;
    EmbeddedEnergy::Shape shape;
};

EmbeddedDeformation::EmbeddedDeformation(SurfaceMesh surface, HandlePoints handles,
                                         const EmbeddedDeformationOptions& options)
    : HandleMethod(std::move(surface), std::move(handles)), options_(options)
{
    require_valid(options);
}

EmbeddedDeformation::~EmbeddedDeformation() = default;

void EmbeddedDeformation::build(PointsView points, SpaceReport& report, const Progress& progress)
{
    const SurfaceMesh mesh = surface_in_unit();
    const DeformationGraph graph(mesh, options_.nodes, progress);
    progress.tick(0.75, "computing weights");
    const double edge = graph.edge_length();
    const Points held = in_unit(view(handles().held().points())), bound = in_unit(points);
    const std::vector<HandleReach::Shares> held_shares = graph.shares(view(held));
    Points carriers = Points::Zero(held.rows(), 3);
    for (Eigen::Index p = 0; p < held.rows(); ++p)
        for (const auto& share : held_shares[p])
            carriers.row(p) += share.weight * graph.places().row(share.map);
    Pulls pulls = pulls_of(handles().held(), held_shares, holds(handles().held(), held, carriers, edge),
                           graph.pieces());
    Points pullable(held.rows() + graph.size(), 3);
    pullable << held, graph.places();
    Points pulled(static_cast<Eigen::Index>(pulls.points.size()), 3);
    for (Eigen::Index k = 0; k < pulled.rows(); ++k)
        pulled.row(k) = pullable.row(pulls.points[k]) / edge + pulls.sides[k].transpose();
    std::vector<HandleReach::Shares> shares = graph.shares(view(bound));
    const HandleReach reach(handles(), held, held_shares, edge);
    parallel_for(
        static_cast<int>(shares.size()),
        [&](int i) { reach.add_to(shares[i], bound.row(i).transpose(), graph.size()); }, 256);
    BlendedMaps blended;
    for (const HandleReach::Shares& own : shares)
        blended.add(own);
    progress.tick(0.9, "factorising");
    EmbeddedEnergy energy(graph.edges(), pulls.pulls, handles().count() + 1,
                          {options_.rotation, options_.regularity, options_.pulls}, graph.places() / edge,
                          pulled);
    std::vector<int> node_carriers = nearest_points(graph.places(), view(bound)),
                     handle_carriers = nearest_points(pullable, view(bound));
    std::unique_ptr<const Binding> next(
        new Binding{(unit() * graph.places()).rowwise() + centre().transpose(),
                    graph.edges(),
                    edge,
                    std::move(pulls),
                    std::move(energy),
                    std::move(blended),
                    std::move(node_carriers),
                    std::move(handle_carriers),
                    {}});
    report.weight_bytes = next->points.bytes();
    progress.tick(1.0, "bound");
    bound_ = std::move(next);
}

SolveReport EmbeddedDeformation::solve(const std::vector<HeldMotion>& motions, PointsView base, bool enters,
                                       Workspace& work) const
{
    const Binding& own = *bound_;
    std::vector<HeldMotion> moves = with_rest(motions);
    for (HeldMotion& motion : moves)
        motion.move /= own.edge;
    work.shape = own.energy.rest();
    if (enters) {
        Points places = work.shape.places, pulled = work.shape.points;
        const auto move = [&](int point) -> Eigen::RowVector3d {
            return (base.row(point) - points().row(point)) / (unit() * own.edge);
        };
        for (Eigen::Index j = 0; j < places.rows(); ++j)
            places.row(j) += move(own.node_carriers[j]);
        for (Eigen::Index k = 0; k < pulled.rows(); ++k)
            pulled.row(k) += move(own.handle_carriers[own.pulls.points[k]]);
        work.shape = own.energy.shape(places, pulled);
    }
    EmbeddedProblem problem(own.energy, work.shape, moves);
    work.x = problem.start();
    return minimize(problem, work.x, descent(options_.max_iterations, options_.tolerance, own.nodes.rows()),
                    {}, &work.descent);
}

SolveReport EmbeddedDeformation::deform(const std::vector<HeldMotion>& motions, PointsView base, bool enters,
                                        PositionsOut out) const
{
    const Binding& own = *bound_;
    const auto work = own.workspaces.take([] { return std::make_unique<Workspace>(); });
    const SolveReport report = solve(motions, base, enters, *work);
    Poses maps = displacements(work->x, work->shape.places);
    for (Pose& map : maps)
        map.col(3) *= own.edge;
    append_displacements(motions, maps);
    for (Pose& map : maps)
        map.col(3) *= unit();
    std::visit([&](auto* to) { own.points.apply(maps, centre(), base, base, to); }, out);
    return report;
}

const EmbeddedDeformation::Binding& EmbeddedDeformation::bound() const
{
    if (!bound_)
        throw InvalidConstraint("no points are bound to the handles: call bind() first");
    return *bound_;
}

EmbeddedDeformation::Graph EmbeddedDeformation::graph() const
{
    const AccessLock shared = reading();
    const Binding& own = bound();
    const auto pulls = static_cast<Eigen::Index>(own.pulls.pulls.size());
    Graph result{.nodes = own.nodes, .edges = own.edges, .edge_length = own.edge * unit(), .pulls = {}};
    result.pulls = (own.energy.rest().points * result.edge_length).rowwise() + centre().transpose();
    result.pull_weights = RowMatrix::Zero(pulls, own.nodes.rows());
    for (Eigen::Index k = 0; k < pulls; ++k) {
        const EmbeddedEnergy::Pull& pull = own.pulls.pulls[k];
        result.strengths.push_back(pull.strength);
        result.pull_handles.push_back(pull.handle);
        for (const auto& share : pull.shares)
            result.pull_weights(k, share.map) = share.weight;
    }
    return result;
}

RowMatrix EmbeddedDeformation::weights() const
{
    const AccessLock shared = reading();
    const Binding& own = bound();
    RowMatrix W = RowMatrix::Zero(own.points.point_count(), own.nodes.rows() + handles().count());
    for (int i = 0; i < own.points.point_count(); ++i)
        for (const auto& share : own.points.shares(i))
            W(i, share.map) = share.weight;
    return W;
}

HandleMethod::Network EmbeddedDeformation::posed_network(const std::vector<HeldMotion>& motions,
                                                         PointsView base, bool enters) const
{
    const Binding& own = bound();
    Workspace work;
    solve(motions, base, enters && base.rows() > 0, work);
    Points nodes = work.shape.places;
    for (Eigen::Index j = 0; j < nodes.rows(); ++j)
        nodes.row(j) += work.x.row(4 * j + 3);
    return {(nodes * own.edge * unit()).rowwise() + centre().transpose(), own.edges};
}

EmbeddedDeformation::Answer EmbeddedDeformation::answer(const Poses& poses, Start start, double tolerance,
                                                        int max_iterations) const
{
    const AccessLock shared = reading();
    const Binding& own = bound();
    std::vector<HeldMotion> motions = with_rest(handles().motions(poses));
    for (HeldMotion& motion : motions)
        motion.move /= own.edge;
    EmbeddedProblem problem(own.energy, own.energy.rest(), motions);
    Answer result;
    result.unknowns = start == Start::handles ? problem.start() : problem.start_without_rotations();
    result.report = minimize(problem, result.unknowns, descent(max_iterations, tolerance, own.nodes.rows()));
    for (Eigen::Index j = 0; j < own.nodes.rows(); ++j) {
        result.unknowns.middleRows<3>(4 * j) += Matrix3::Identity();
        result.unknowns.row(4 * j + 3) *= own.edge * unit();
        result.unknowns.row(4 * j + 3) += own.nodes.row(j);
    }
    return result;
}

std::vector<std::string> EmbeddedDeformation::changed_settings(const SpaceMethod& former) const
{
    return changed(options_, static_cast<const EmbeddedDeformation&>(former).options_,
                   HandleMethod::changed_settings(former));
}

void EmbeddedDeformation::swap_binding(HandleMethod& other)
{
    std::swap(bound_, static_cast<EmbeddedDeformation&>(other).bound_);
}

} // namespace sinew
