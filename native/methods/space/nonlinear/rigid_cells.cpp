// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/rigid_cells.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/coarse_start.h"
#include "native/local_global/bodies/body_problem.h"
#include "native/mesh/regions.h"
#include "native/methods/space/nonlinear/cells/cell_grid.h"
#include "native/methods/space/nonlinear/handles/handle_reach.h"
#include "native/operators/fits/rotation_fit.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

namespace sinew {

namespace {

/// An energy below this share of RigidBodies::scale() is rounding.
constexpr double rounding_floor = 1e-14;
constexpr int sweeps = 2;

/// Which handle each cell follows, and how strongly.
struct CellHandles
{
    std::vector<int> handle;      ///< or -1; after the last one, that of cells that stay
    std::vector<double> strength; ///< 1 holds the cell
};

/// \param held  (c, 3) the points of the handles, in the coordinates of the grid.
CellHandles handles_of_cells(const CellGrid& grid, const HandlePoints& handles, const Points& held)
{
    std::vector<int> cells;
    Points carriers(held.rows(), 3);
    for (int p = 0; p < held.rows(); ++p) {
        cells.push_back(grid.cell_at(held.row(p).transpose()));
        const Cell& cell = grid.cells()[cells[p]];
        const Eigen::Array3d off = held.row(p).transpose() - cell.centre; // to the nearest place in the cell
        carriers.row(p) = (cell.centre + off.max(-cell.half).min(cell.half).matrix()).transpose();
    }
    const std::vector<double> holding = holds(handles, held, carriers, grid.side());
    struct Sum
    {
        double points = 0.0, strength = 0.0;
    };
    std::vector<std::map<int, Sum>> tallies(static_cast<std::size_t>(grid.size()));
    std::vector<char> has_cell(static_cast<std::size_t>(handles.handle_count()), 1);
    for (int p = 0; p < held.rows(); ++p) {
        if (holding[p] == 0.0)
            continue;
        Sum& sum = tallies[cells[p]][handles.handle_of(p)];
        sum.points += 1.0;
        sum.strength += handles.weight(p) * holding[p];
        has_cell[handles.handle_of(p)] = 0;
    }
    CellHandles cell_handles;
    for (const auto& tally : tallies) {
        const auto most =
            std::ranges::max_element(tally, {}, [](const auto& entry) { return entry.second.points; });
        cell_handles.handle.push_back(most == tally.end() ? -1 : most->first);
        cell_handles.strength.push_back(most == tally.end() ? 0.0
                                                            : most->second.strength / most->second.points);
        if (most != tally.end())
            has_cell[most->first] = 1;
    }
    std::vector<int> without;
    for (int h = 0; h < handles.handle_count(); ++h)
        if (!has_cell[h])
            without.push_back(h);
    if (!without.empty())
        throw InvalidConstraint(
            "handle " + std::to_string(without[0]) +
                (without.size() > 1 ? " and " + std::to_string(without.size() - 1) + " more" : "") +
                ": no cell is left to hold, as other handles have more points in all of "
                "theirs; use more cells",
            Error::Element::handle, without);
    return cell_handles;
}

HandleGraph graph_of(const CellGrid& grid, const CellHandles& cell_handles,
                     const std::vector<BodyJoint>& joints)
{
    std::vector<std::map<int, double>> neighbours(static_cast<std::size_t>(grid.size()));
    std::vector<double> diagonal(static_cast<std::size_t>(grid.size()), 0.0);
    for (const BodyJoint& joint : joints)
        for (const int side : {0, 1}) {
            neighbours[joint.body[side]][joint.body[1 - side]] += joint.weight;
            diagonal[joint.body[side]] += joint.weight;
        }
    GraphEdges edges;
    for (const auto& own : neighbours) {
        for (const auto& [other, weight] : own) {
            edges.neighbours.push_back(other);
            edges.weights.push_back(weight);
        }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }
    GraphHandles held;
    held.idle.assign(static_cast<std::size_t>(grid.size()), 0);
    for (int c = 0; c < grid.size(); ++c) {
        const bool is_hard = cell_handles.strength[c] >= 1.0;
        held.hard.push_back(is_hard ? cell_handles.handle[c] : -1);
        if (!is_hard && cell_handles.handle[c] >= 0)
            held.pulls.push_back({c, cell_handles.handle[c],
                                  cell_handles.strength[c] / (1.0 - cell_handles.strength[c]) *
                                      (diagonal[c] > 0.0 ? diagonal[c] : 1.0)});
    }
    return {std::move(edges), std::move(held)};
}

} // namespace

struct RigidCells::Workspace
{
    CoarseStart::Workspace start;
    std::vector<Eigen::Quaterniond> rotations;
    BodyBuffers bodies;
    LbfgsWorkspace descent;
    GraphGoals goals;
    Points centres, x;
};

/// Cells have the numbers of the graph.
struct RigidCells::Binding
{
    std::vector<Cell> cells; ///< in the coordinates of motions
    std::vector<CellFace> faces;
    Points rest; ///< (m, 3) their centres
    Vector3 first_middle; ///< of the points of the first handle
    bool has_still_cells; ///< whether a piece is near no handle
    ArapSystem graph;
    RigidBodies bodies;
    CoarseStart start;
    BlendedMaps points;
    mutable Pool<Workspace> workspaces;
};

RigidCells::RigidCells(SurfaceMesh surface, HandlePoints handles, const RigidCellsOptions& options)
    : HandleMethod(std::move(surface), std::move(handles)), options_(options)
{
    require_valid(options);
}

RigidCells::~RigidCells() = default;

void RigidCells::build(PointsView points, SpaceReport& report, const Progress& progress)
{
    CellGrid grid(surface_in_unit(), options_.cells, options_.levels, progress);
    CellHandles cell_handles =
        handles_of_cells(grid, handles().held(), in_unit(view(handles().held().points())));
    std::vector<char> held;
    for (const int handle : cell_handles.handle)
        held.push_back(handle >= 0);
    const std::vector<int> still = grid.join_loose_pieces(held);
    for (const int cell : still) {
        cell_handles.handle[cell] = handles().count();
        cell_handles.strength[cell] = 1.0;
    }
    std::vector<BodyJoint> joints;
    for (const CellFace& face : grid.faces()) {
        const double halves = grid.cells()[face.cell[0]].half + grid.cells()[face.cell[1]].half;
        joints.push_back({{face.cell[0], face.cell[1]}, 4.0 * face.half * face.half / halves});
    }
    Points centres(grid.size(), 3);
    for (int c = 0; c < grid.size(); ++c)
        centres.row(c) = grid.cells()[c].centre.transpose();
    progress.tick(0.6, "factorising");
    ArapSystem graph(
        graph_of(grid, cell_handles, joints),
        {.rigidity = std::vector<double>(static_cast<std::size_t>(grid.size()), 1.0), .triangles = {}},
        centres);
    std::vector<Cell> cells;
    for (const int old : graph.order())
        cells.push_back(grid.cells()[old]);
    Points rest = centres(graph.order(), Eigen::all);
    const std::vector<int> renamed = new_numbers(graph.order());
    std::vector<CellFace> faces = grid.faces();
    double square = 0.0;
    for (std::size_t k = 0; k < faces.size(); ++k) {
        for (const int side : {0, 1})
            faces[k].cell[side] = joints[k].body[side] = renamed[faces[k].cell[side]];
        square += faces[k].half * faces[k].half / static_cast<double>(faces.size());
    }
    RigidBodies bodies(
        graph, std::move(joints),
        [&](int k) {
            const CellFace& face = faces[k];
            JointShape shape;
            for (const int side : {0, 1})
                shape.lever[side] = face.middle - cells[face.cell[side]].centre;
            Vector3 extents = Vector3::Constant(face.half * face.half / 3.0);
            if (face.axis >= 0)
                extents[face.axis] = 0.0;
            shape.form = extents.asDiagonal();
            return shape;
        },
        sweeps);
    CoarseStart start(graph.nodes(),
                      {.rigidity = graph.cells().rigidity, .smoothing = square / 6.0, .triangles = {}}, rest,
                      progress);
    progress.tick(0.8, "computing weights");
    const Points bound = in_unit(points);
    const auto named = [&](std::vector<HandleReach::Shares> shares) {
        for (HandleReach::Shares& own : shares)
            for (BlendedMaps::Share& share : own)
                share.map = renamed[share.map];
        return shares;
    };
    std::vector<int> unused;
    const Points held_points = in_unit(view(handles().held().points()));
    const std::vector<HandleReach::Shares> held_shares = named(grid.shares(view(held_points), unused));
    std::vector<HandleReach::Shares> shares = named(grid.shares(view(bound), report.outside));
    const HandleReach reach(handles(), held_points, held_shares, grid.side());
    parallel_for(
        static_cast<int>(shares.size()),
        [&](int i) { reach.add_to(shares[i], bound.row(i).transpose(), grid.size()); }, 256);
    BlendedMaps blended;
    for (const HandleReach::Shares& own : shares)
        blended.add(own);
    const Vector3 first = held_points.topRows(handles().held().count(0)).colwise().mean().transpose();
    std::unique_ptr<const Binding> next(new Binding{std::move(cells),
                                                    std::move(faces),
                                                    std::move(rest),
                                                    first,
                                                    !still.empty(),
                                                    std::move(graph),
                                                    std::move(bodies),
                                                    std::move(start),
                                                    std::move(blended),
                                                    {}});
    report.weight_bytes = next->points.bytes();
    progress.tick(1.0, "bound");
    bound_ = std::move(next);
}

/// One solve.
class RigidCells::Solve
{
public:
    Solve(const Binding& bound, const std::vector<HeldMotion>& motions, Workspace& work)
        : bound_(bound), work_(work), targets_{poses_, view(bound.rest), {}, nullptr}
    {
        // All is relative to the rigid motion of the first handle. So nothing is left to solve where all move
        // like that, and numbers stay small.
        turn_ = fit_rotation(Matrix3::Identity() + motions[0].turn);
        middle_ = bound.first_middle;
        there_ = middle_ + motions[0](middle_);
        for (const HeldMotion& motion : bound.has_still_cells ? with_rest(motions) : motions) {
            Pose& pose = poses_.emplace_back();
            pose.leftCols<3>() = turn_.transpose() * (Matrix3::Identity() + motion.turn);
            pose.col(3) = turn_.transpose() * (middle_ + motion(middle_) - there_) + middle_ -
                          pose.leftCols<3>() * middle_;
        }
        work.centres = bound.rest;
        work.goals.set(bound.graph, targets_);
        const int free = bound.graph.free_count();
        for (int c = free; c < bound.graph.size(); ++c)
            work.centres.row(c) =
                apply(poses_[bound.graph.nodes().hard(c)], bound.rest.row(c).transpose()).transpose();
        problem_.emplace(bound.graph, bound.bodies, bound.bodies.rest_numbers(), work.centres,
                         work.goals.pulls, &work.bodies);
        for (int c = free; c < bound.graph.size(); ++c)
            problem_->set_rotation(c, poses_[bound.graph.nodes().hard(c)].leftCols<3>());
    }

    SolveReport run(Start from, double tolerance, int max_iterations)
    {
        const int free = bound_.graph.free_count();
        work_.x = bound_.rest.topRows(free);
        if (free == 0)
            return {.converged = true};
        if (from == Start::cascade) {
            bound_.start.rotations(targets_, work_.start, work_.rotations);
            parallel_for(free,
                         [&](int c) { problem_->set_rotation(c, work_.rotations[c].toRotationMatrix()); });
            problem_->centres_for_rotations(work_.x);
        }
        return minimize(*problem_, work_.x,
                        {.max_iterations = max_iterations,
                         .tolerance = tolerance,
                         .floor = rounding_floor * bound_.bodies.scale(bound_.bodies.rest_numbers())},
                        {}, &work_.descent);
    }

    /// (m, 3) where the cells are, in the coordinates of motions.
    Points centres()
    {
        Points result = work_.centres;
        result.topRows(bound_.graph.free_count()) = work_.x;
        for (Eigen::Index c = 0; c < result.rows(); ++c)
            result.row(c) = (there_ + turn_ * (result.row(c).transpose() - middle_)).transpose();
        return result;
    }

    /// The displacements of the cells.
    Poses maps()
    {
        const Points centres = this->centres();
        Poses maps(static_cast<std::size_t>(bound_.graph.size()));
        for (int c = 0; c < bound_.graph.size(); ++c) {
            maps[c].leftCols<3>() = turn_ * problem_->rotation(c) - Matrix3::Identity();
            maps[c].col(3) = (centres.row(c) - bound_.rest.row(c)).transpose() -
                             maps[c].leftCols<3>() * bound_.rest.row(c).transpose();
        }
        return maps;
    }

private:
    const Binding& bound_;
    Workspace& work_;
    Matrix3 turn_;
    Vector3 middle_, there_;
    Poses poses_;
    Targets targets_;
    std::optional<BodyProblem> problem_;
};

SolveReport RigidCells::deform(const std::vector<HeldMotion>& motions, PointsView base, bool,
                               PositionsOut out) const
{
    const Binding& own = *bound_;
    const auto work = own.workspaces.take([] { return std::make_unique<Workspace>(); });
    Solve solve(own, motions, *work);
    const SolveReport report = solve.run(Start::cascade, options_.tolerance, options_.max_iterations);
    Poses maps = solve.maps();
    append_displacements(motions, maps);
    for (Pose& map : maps)
        map.col(3) *= unit();
    std::visit([&](auto* to) { own.points.apply(maps, centre(), view(points()), base, to); }, out);
    return report;
}

const RigidCells::Binding& RigidCells::bound() const
{
    if (!bound_)
        throw InvalidConstraint("no points are bound to the handles: call bind() first");
    return *bound_;
}

RigidCells::Cells RigidCells::cells() const
{
    const AccessLock shared = reading();
    const Binding& own = bound();
    Cells result;
    result.centres.resize(own.graph.size(), 3);
    for (int c = 0; c < own.graph.size(); ++c) {
        result.centres.row(c) = centre().transpose() + unit() * own.rest.row(c);
        result.sides.push_back(2.0 * unit() * own.cells[c].half);
        const int handle = own.graph.nodes().hard(c);
        result.handles.push_back(handle < handles().count() ? handle : -1);
    }
    for (const CellFace& face : own.faces)
        result.links.push_back({face.cell[0], face.cell[1]});
    return result;
}

HandleMethod::Network RigidCells::posed_network(const std::vector<HeldMotion>& motions, PointsView,
                                                bool) const
{
    const Binding& own = bound();
    Workspace work;
    Solve solve(own, motions, work);
    solve.run(Start::cascade, options_.tolerance, options_.max_iterations);
    return {(unit() * solve.centres()).rowwise() + centre().transpose(), cells().links};
}

RigidCells::Answer RigidCells::answer(const Poses& poses, Start start, double tolerance,
                                      int max_iterations) const
{
    const AccessLock shared = reading();
    const Binding& own = bound();
    const std::vector<HeldMotion> motions = handles().motions(poses);
    Workspace work;
    Solve solve(own, motions, work);
    const SolveReport report = solve.run(start, tolerance, max_iterations);
    return {(unit() * solve.centres()).rowwise() + centre().transpose(), report};
}

std::vector<std::string> RigidCells::changed_settings(const SpaceMethod& former) const
{
    return changed(options_, static_cast<const RigidCells&>(former).options_,
                   HandleMethod::changed_settings(former));
}

void RigidCells::swap_binding(HandleMethod& other)
{
    std::swap(bound_, static_cast<RigidCells&>(other).bound_);
}

} // namespace sinew
