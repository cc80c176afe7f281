// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/coarse_start.h"
#include "native/local_global/bodies/body_problem.h"
#include "native/local_global/rows/goals.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/methods/surface/nonlinear/primo/prisms.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/operators/laplacian.h"
#include "native/operators/painted.h"

#include <Eigen/LU>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace sinew {

namespace {

constexpr double least_height = 1e-3; ///< as a share of the largest painted one
/// An energy below this share of RigidBodies::scale() is rounding.
constexpr double rounding_floor = 1e-14;
constexpr double degenerate = 1e-12; ///< the least share of an extent that says something about a normal
/// Prisms that are flatter than their faces are long bend easily: their rotations need more sweeps.
constexpr int sweeps = 2, sweeps_of_flat_prisms = 4;

double mean_edge(const SurfaceMesh& mesh)
{
    double sum = 0.0;
    const std::vector<std::array<int, 2>> edges = mesh.edges();
    for (const auto& [v, w] : edges)
        sum += (mesh.point(v) - mesh.point(w)).norm();
    return edges.empty() ? 0.0 : sum / static_cast<double>(edges.size());
}

/// The map that takes a face to other points: in its plane as these say, and its normal to theirs. Where the
/// face or its image has no normal, a rotation.
Matrix3 map_of_face(const Points& from, const Points& to, const Vector3& area, const Vector3& area_to,
                    const Matrix3& rotation)
{
    const Eigen::RowVector3d middle = from.colwise().mean(), middle_to = to.colwise().mean();
    const Matrix3 P = (from.rowwise() - middle).transpose() * (from.rowwise() - middle);
    const Matrix3 C = (to.rowwise() - middle_to).transpose() * (from.rowwise() - middle);
    const double extent = P.trace();
    if (area.norm() > degenerate * extent && area_to.norm() > degenerate * extent) {
        const Vector3 n = area.normalized();
        const Matrix3 full = P + extent * n * n.transpose();
        if (full.determinant() > degenerate * extent * extent * extent)
            return (C + extent * area_to.normalized() * n.transpose()) * full.inverse();
    }
    return fit_rotation(C + 1e-8 * extent * rotation);
}

/// The workspace of a solve.
struct Workspace
{
    TargetsInUnit in_unit;
    CoarseStart::Workspace start;
    std::vector<Eigen::Quaterniond> rotations;
    BodyBuffers bodies;
    LbfgsWorkspace descent;
    PrismShape shape;
    std::vector<double> numbers;
    GraphGoals goals;
    Points centres, x;
};

/// The results of a bind.
struct Binding
{
    double unit; ///< of the bodies, whose squares fit into single precision
    Points rest; ///< (n, 3)
    Prisms prisms;
    ArapSystem graph;
    PrismShape shape;
    RigidBodies bodies;
    CoarseStart start;
    mutable Pool<Workspace> workspaces;

    Binding(const SurfaceMesh& mesh, double unit, const Regions& regions, Prisms given,
            const std::vector<double>& height, const Progress& progress)
        : unit(unit), rest(mesh.points()), prisms(std::move(given)),
          graph(prisms.graph(regions), {.rigidity = std::vector<double>(prisms.size(), 1.0), .triangles = {}},
                centres(prisms, rest)),
          shape(in_order_of(graph)),
          bodies(
              graph, prisms.joints(), [&](int k) { return prisms.joint_shape(k, shape); },
              mean(height) < mean_edge(mesh) ? sweeps_of_flat_prisms : sweeps)
    {
        const double square = std::inner_product(height.begin(), height.end(), height.begin(), 0.0) /
                              static_cast<double>(height.size());
        // Two prisms that turn by a small angle against each other about their edge cost h^2 / 6 times its
        // square; rotations of ARAP cost as much with this smoothness.
        start = CoarseStart(graph.nodes(),
                            {.rigidity = graph.cells().rigidity, .smoothing = square / 6.0, .triangles = {}},
                            shape.centres, progress);
    }

private:
    static double mean(const std::vector<double>& values)
    {
        return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    }
    static Points centres(const Prisms& prisms, const Points& rest)
    {
        PrismShape shape;
        prisms.set_shape(view(rest), shape);
        return shape.centres;
    }
    PrismShape in_order_of(const ArapSystem& of)
    {
        prisms.renumber(of.order());
        PrismShape result;
        prisms.set_shape(view(rest), result);
        return result;
    }
};

/// One solve.
class Solve
{
public:
    Solve(const Binding& bound, const Regions& regions, const Targets& given, Workspace& work)
        : bound_(bound), regions_(regions), given_(given), work_(work),
          targets_(work.in_unit.of(given, view(bound.rest), bound.unit)),
          bodies_{targets_.poses, view(bound.shape.centres), {}, targets_.from_rest}
    {
        if (targets_.incoming) {
            bound.prisms.set_shape(*targets_.incoming, work.shape);
            bound.bodies.lay_out([&](int k) { return bound.prisms.joint_shape(k, work.shape); },
                                 work.numbers);
            bodies_.incoming.emplace(view(work.shape.centres));
        }
        work.goals.set(bound.graph, bodies_);
        work.centres = shape().centres;
        if (!has_free_bodies())
            return;
        const int free = bound.graph.free_count(), held = bound.prisms.size() - free;
        parallel_for(held, [&](int k) {
            const Points to = corners(free + k, [&](int v) { return target(v); });
            work.centres.row(free + k) = to.colwise().mean();
        });
        problem_.emplace(bound.graph, bound.bodies, numbers(), work.centres, work.goals.pulls, &work.bodies);
        parallel_for(held, [&](int k) { hold(free + k); });
    }

    bool has_free_bodies() const { return bound_.graph.free_count() > 0; }

    /// Sets centres and rotations from the poses alone.
    void start()
    {
        bound_.start.rotations(bodies_, work_.start, work_.rotations);
        parallel_for(bound_.graph.free_count(),
                     [&](int b) { problem_->set_rotation(b, work_.rotations[b].toRotationMatrix()); });
        problem_->centres_for_rotations(work_.x);
    }

    /// Sets them from the vertices of another shape.
    void start(const PointsView& positions)
    {
        work_.x.resize(bound_.graph.free_count(), 3);
        parallel_for(bound_.graph.free_count(), [&](int b) {
            const Points to = corners(b, [&](int v) -> Vector3 { return positions.row(v) / bound_.unit; });
            work_.x.row(b) = to.colwise().mean();
            problem_->set_rotation(b, fit_rotation(map_of(b, to, Matrix3::Identity())));
        });
    }

    SolveReport descend(LbfgsOptions options, const Progress& progress)
    {
        options.floor = rounding_floor * bound_.bodies.scale(numbers());
        SolveReport report = minimize(*problem_, work_.x, options, progress, &work_.descent);
        report.energy *= bound_.unit * bound_.unit;
        return report;
    }

    /// (n, 3) the vertices; those of parts without a handle stay.
    void read_out(Points& positions)
    {
        positions = given_.base();
        const PointsView centres = has_free_bodies() ? problem_->place(work_.x) : view(work_.centres);
        const Prisms& prisms = bound_.prisms;
        parallel_for(static_cast<int>(positions.rows()), [&](int v) {
            if (const int handle = regions_.hard(v); handle >= 0) {
                positions.row(v) = given_.position(v, handle);
            } else if (const int own = prisms.body_of(v); own >= 0) {
                positions.row(v) = bound_.unit * centres.row(own);
            } else if (const auto at = prisms.prisms_at(v); !at.empty()) {
                Vector3 sum = Vector3::Zero();
                for (int b : at)
                    sum +=
                        centres.row(b).transpose() +
                        problem_->rotation(b) * (shape().points.row(v) - shape().centres.row(b)).transpose();
                positions.row(v) = bound_.unit / static_cast<double>(at.size()) * sum;
            }
        });
    }

    /// How many prisms have a face whose vertices end up turned over against them.
    int inverted(const PointsView& positions) const
    {
        const double square = bound_.unit * bound_.unit;
        return static_cast<int>(parallel_sum(bound_.graph.free_count(), [&](int b) {
            const Vector3 area = shape().area.row(b);
            const Vector3 shown = bound_.prisms.area(positions, b) / square;
            return shown.dot(problem_->rotation(b) * area) < -1e-9 * area.squaredNorm() ? 1.0 : 0.0;
        }));
    }

private:
    const PrismShape& shape() const { return given_.incoming ? work_.shape : bound_.shape; }
    const std::vector<double>& numbers() const
    {
        return given_.incoming ? work_.numbers : bound_.bodies.rest_numbers();
    }
    /// Where the handle of a vertex that is held wants it.
    Vector3 target(int v) const { return targets_.position(v, regions_.hard(v)); }
    template <class Place>
    Points corners(int b, Place&& place) const
    {
        const std::span<const int> own = bound_.prisms.corners(b);
        Points result(static_cast<Eigen::Index>(own.size()), 3);
        for (std::size_t k = 0; k < own.size(); ++k)
            result.row(static_cast<Eigen::Index>(k)) = place(own[k]).transpose();
        return result;
    }
    /// The map that takes the face of a body to other corners.
    Matrix3 map_of(int b, const Points& to, const Matrix3& rotation) const
    {
        const Points from = corners(b, [&](int v) -> Vector3 { return shape().points.row(v); });
        return map_of_face(from, to, shape().area.row(b), Prisms::area(to), rotation);
    }
    void hold(int b)
    {
        const Matrix3 rotation = fit_rotation(targets_.poses[bound_.prisms.handle(b)].leftCols<3>());
        problem_->set_rotation(b, map_of(b, corners(b, [&](int v) { return target(v); }), rotation));
    }

    const Binding& bound_;
    const Regions& regions_;
    const Targets& given_;
    Workspace& work_;
    const Targets targets_; ///< of the vertices, in units of the bodies
    Targets bodies_;        ///< of the centres of the bodies
    std::optional<BodyProblem> problem_;
};

} // namespace

struct Primo::Impl
{
    std::vector<double> height; ///< one per vertex, as a share
    double unit = 1.0;          ///< see normal_unit()
    int degenerate_faces = -1;  ///< counted by the first bind
    int factorizations = 0;
    std::unique_ptr<const Binding> bound; ///< null before the first bind
};

Primo::Primo(const SurfaceMesh& rest, const PrimoOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    impl_->unit = normal_unit(rest.points());
    impl_->height = painted(options.height, rest.vertex_count(), least_height, "height");
    if (impl_->height.empty())
        throw InvalidOption("height: zero everywhere; give at least one vertex a positive value");
}

void Primo::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const std::optional<SurfaceMesh> scaled = in_unit(rest(), self.unit);
    const SurfaceMesh& mesh = scaled ? *scaled : rest();
    if (self.degenerate_faces < 0)
        self.degenerate_faces = degenerate_face_count(mesh);
    std::vector<double> height = self.height;
    const std::vector<double> sizes = part_sizes(mesh);
    for (std::size_t v = 0; v < height.size(); ++v)
        height[v] *= sizes[v];
    Prisms prisms(mesh, regions, height);
    progress.tick(0.2, "factorising");
    auto next =
        std::make_unique<const Binding>(mesh, self.unit, regions, std::move(prisms), height, progress);
    progress.tick(1.0, "bound");

    self.bound = std::move(next);
    self.factorizations += 2;
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = self.factorizations;
    report.factor_bytes = self.bound->graph.factor_bytes() + self.bound->bodies.rotation_factor().bytes();
    report.factor_bytes += self.bound->start.factor_bytes();
}

void Primo::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<Primo&>(other).impl_;
    std::swap(impl_->degenerate_faces, others.degenerate_faces);
    std::swap(impl_->factorizations, others.factorizations);
    std::swap(impl_->bound, others.bound);
}

SolveReport Primo::deform(const SolveRequest& request, const Targets& targets, Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    Solve solve(bound, regions(), targets, *work);
    SolveReport report{.converged = true};
    if (solve.has_free_bodies()) {
        if (request.start)
            solve.start(*request.start);
        else
            solve.start();
        report = solve.descend({.max_iterations = request.max_iterations.value_or(options().max_iterations),
                                .tolerance = request.tolerance.value_or(options().tolerance)},
                               request.progress);
    }
    solve.read_out(positions);
    if (solve.has_free_bodies())
        report.inverted_faces = solve.inverted(view(positions));
    return report;
}

} // namespace sinew
