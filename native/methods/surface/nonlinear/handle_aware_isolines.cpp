// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/handle_aware_isolines.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/handles/constrained_system.h"
#include "native/handles/map_blend.h"
#include "native/local_global/reduced/rotation_clusters.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/methods/space/weights/point_weights.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/operators/laplacian.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

/// Shares that differ by less are equal, so that rounding does not choose the band.
constexpr double equal = 1e-6;
constexpr int many_bands = 1000; ///< above, a bind takes many seconds, and each frame tenths of one
constexpr double energy_factor = 4.0; ///< E for F of local_global/reduced/rotation_clusters.h

/// A connected part that handles touch.
struct Part
{
    std::vector<int> vertices;
    std::vector<int> handles;              ///< of its part handles
    std::vector<std::vector<int>> patches; ///< vertices around each of these handles, in this part
    Vector3 centre;
    int first_band = 0;
    RowMatrix shares; ///< (bands, part handles) the means of the fields
    std::unique_ptr<const RotationClusters> clusters;
    PointWeights answers; ///< (vertices, 4 part handles + 3 bands)

    int part_handle_count() const { return static_cast<int>(handles.size()); }
    int band_count() const { return static_cast<int>(shares.rows()); }

    RotationClusters::State start(const Poses& poses) const;
};

RotationClusters::State Part::start(const Poses& poses) const
{
    return clusters->start(poses, mean_rotations(shares, poses, rigid_mean(poses).leftCols<3>()));
}

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system; ///< of the Laplacian
    double unit = 1.0; ///< of all that is reduced, so that single precision holds it
    std::vector<Part> parts;
    std::vector<int> bands;  ///< (n) over all parts; -1 in parts without a handle
    std::vector<Constraint> held;
    std::vector<int> idle;
};

struct Frame
{
    Points moved, answers; ///< of the vertices of a part
    Points moves;          ///< (4 part handles + 3 bands, 3)
};

/// Divides a part into bands: those of its part handles one after the other, from their handles outwards.
void divide(Part& part, int group, const HandleFields& fields, int bands_per_handle, std::vector<int>& labels)
{
    const int first = fields.groups().offsets[group], part_handles = part.part_handle_count();
    std::vector<int> own(part.vertices.size());
    std::vector<double> least(part_handles, 1.0);
    const auto share = [&](std::size_t k, int s) { return fields.share(part.vertices[k], first + s); };
    for (std::size_t k = 0; k < own.size(); ++k) {
        for (int s = 1; s < part_handles; ++s)
            if (share(k, s) > share(k, own[k]) + equal)
                own[k] = s;
        least[own[k]] = std::min(least[own[k]], share(k, own[k]));
    }
    std::vector<int> numbers(static_cast<std::size_t>(part_handles) * bands_per_handle, 0);
    for (std::size_t k = 0; k < own.size(); ++k) {
        const double range = 1.0 - least[own[k]];
        const double depth = range > equal ? (1.0 - share(k, own[k])) / range : 0.0;
        own[k] = own[k] * bands_per_handle +
                 std::clamp(static_cast<int>((depth - equal) * bands_per_handle), 0, bands_per_handle - 1);
        ++numbers[own[k]];
    }
    std::vector<int> members;
    for (int& number : numbers) { // bands without a vertex are left out
        if (number == 0)
            continue;
        members.push_back(number);
        number = static_cast<int>(members.size()) - 1;
    }
    part.shares = RowMatrix::Zero(static_cast<Eigen::Index>(members.size()), part_handles);
    for (std::size_t k = 0; k < own.size(); ++k) {
        const int band = numbers[own[k]];
        labels[part.vertices[k]] = part.first_band + band;
        for (int s = 0; s < part_handles; ++s)
            part.shares(band, s) += share(k, s) / members[band];
    }
}

/// The parts with a handle, divided into bands.
std::vector<Part> parts_of(const SurfaceMesh& mesh, const Regions& regions, const HandleFields& fields,
                           int bands_per_handle, std::vector<int>& labels)
{
    const HandleGroups& groups = fields.groups();
    std::vector<Part> parts(groups.count());
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (groups.group[v] >= 0)
            parts[groups.group[v]].vertices.push_back(v);
    const std::vector<std::vector<int>> patches = handle_patches(mesh, regions);
    int bands = 0;
    for (int g = 0; g < groups.count(); ++g) {
        Part& part = parts[g];
        part.centre.setZero();
        for (const int v : part.vertices)
            part.centre += mesh.point(v) / static_cast<double>(part.vertices.size());
        part.handles.assign(groups.handles.begin() + groups.offsets[g],
                            groups.handles.begin() + groups.offsets[g + 1]);
        for (const int handle : part.handles) {
            std::vector<int>& patch = part.patches.emplace_back();
            std::ranges::copy_if(patches[handle], std::back_inserter(patch),
                                 [&](int v) { return groups.group[v] == g; });
        }
        part.first_band = bands;
        divide(part, g, fields, bands_per_handle, labels);
        bands += part.band_count();
    }
    return parts;
}

/// What eliminates the points. Parts do not feel each other, so their columns lie over each other.
struct Elimination
{
    RowMatrix X;  ///< (n, 4 part handles of a part) the answers to affine poses of the handles
    RowMatrix AX; ///< the system's matrix times X
    RowMatrix Z;  ///< (n, 3 bands of a part) the answers to the rotations
    /// A soft pull: its row of X if it were exact, and its stiffness.
    struct Pull
    {
        VectorX aim;
        double stiffness;
    };
    std::vector<std::vector<Pull>> pulls; ///< (n)

    void complete(Part& part, const ClusterLoads& loads) const;
};

void Elimination::complete(Part& part, const ClusterLoads& loads) const
{
    const Eigen::Index poses = 4 * static_cast<Eigen::Index>(part.part_handle_count()),
                       turns = 3 * static_cast<Eigen::Index>(part.band_count()),
                       first = 3 * static_cast<Eigen::Index>(part.first_band);
    RowMatrix G = RowMatrix::Zero(turns, turns), H = RowMatrix::Zero(turns, poses);
    MatrixX K = MatrixX::Zero(poses, poses);
    RowMatrix rows(PointWeights::part, poses + turns), forces(PointWeights::part, poses);
    const int count = static_cast<int>(part.vertices.size());
    part.answers = PointWeights(count, Points::Zero(poses + turns, 3), 0, {});
    for (int k = 0; k < count; ++k) {
        const int v = part.vertices[k], at = k % PointWeights::part;
        const auto own = X.row(v).head(poses);
        const auto turned = Z.row(v).head(turns);
        rows.row(at) << own, turned;
        forces.row(at) = AX.row(v).head(poses);
        if (at + 1 == PointWeights::part || k + 1 == count) {
            part.answers.set_rows(k - at, rows.topRows(at + 1));
            K += transposed_product(rows.topLeftCorner(at + 1, poses), forces.topRows(at + 1));
        }
        for (const auto& [aim, stiffness] : pulls[v])
            K += stiffness * ((aim - own.transpose()) * aim.transpose() - aim * own);
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(loads.B, v); it; ++it) {
            G.row(it.col() - first) += it.value() * turned;
            H.row(it.col() - first) += it.value() * own;
        }
    }
    const auto begin = loads.own.begin() + part.first_band;
    part.clusters = std::make_unique<const RotationClusters>(
        std::vector<Matrix3>(begin, begin + part.band_count()), 0.5 * (G + G.transpose()), MatrixX(H),
        0.5 * (K + K.transpose()));
}

/// \param diagonal  (n) of the Laplacian, without soft pulls.
void eliminate(std::vector<Part>& parts, const ConstrainedSystem& system, const HandleGroups& groups,
               const Regions& regions, const SurfaceMesh& mesh, const VectorX& diagonal,
               const ClusterLoads& loads, double unit, const Progress& progress)
{
    const int n = mesh.vertex_count();
    Eigen::Index poses = 0, turns = 0;
    for (const Part& part : parts) {
        poses = std::max<Eigen::Index>(poses, 4 * part.part_handle_count());
        turns = std::max<Eigen::Index>(turns, 3 * part.band_count());
    }
    const std::vector<Constraint> constraints = regions.constraints();
    MatrixX columns = MatrixX::Zero(static_cast<Eigen::Index>(constraints.size()), poses);
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int v = constraints[row].vertex, g = groups.group[v];
        const int slot = groups.part_handle(constraints[row]) - groups.offsets[g];
        columns.block<1, 4>(static_cast<Eigen::Index>(row), 4 * slot)
            << (mesh.point(v) - parts[g].centre).transpose() / unit,
            1.0;
    }
    Elimination eliminated;
    eliminated.pulls.resize(n);
    const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
    const std::size_t softs = constraints.size() - regions.soft().size();
    for (std::size_t k = 0; k < regions.soft().size(); ++k) {
        const int v = regions.soft()[k].vertex;
        eliminated.pulls[v].push_back(
            {columns.row(static_cast<Eigen::Index>(softs + k))
                 .head(4 * parts[groups.group[v]].part_handle_count()),
             regions.soft()[k].stiffness() * (diagonal[v] > 0 ? diagonal[v] : mean)});
    }
    eliminated.X = system.spread(columns);
    eliminated.AX = system.matrix() * eliminated.X;
    progress.tick(0.6, "eliminating the points");
    eliminated.Z = RowMatrix::Zero(n, turns);
    for (const Part& part : parts)
        for (const int v : part.vertices)
            for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(loads.B, v); it; ++it)
                eliminated.Z(v, it.col() - 3 * part.first_band) = it.value();
    eliminated.Z = system.answer(eliminated.Z);
    progress.tick(0.9, "storing the answers");
    for (Part& part : parts)
        eliminated.complete(part, loads);
}

} // namespace

struct HandleAwareIsolines::Impl
{
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
    mutable Pool<Frame> frames;
};

HandleAwareIsolines::HandleAwareIsolines(const SurfaceMesh& rest, const HandleAwareIsolinesOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
}

void HandleAwareIsolines::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const double unit = normal_unit(rest().points());
    const int n = rest().vertex_count(), bands_per_handle = (options().bands + 1) / 2;
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), Discretization::cotan, metric));
    make_weights_positive(*L);
    const VectorX diagonal = L->diagonal();
    HandleGroups groups(regions, connected_components(rest()));
    std::vector<int> labels(n, -1);
    std::vector<Part> parts;
    progress.tick(0.1, "factorising");
    bound.system.factorize(std::move(L), regions, [&] {
        progress.tick(0.4, "computing the fields");
        const HandleFields fields = options().field == Field::harmonic
                                        ? HandleFields(std::move(groups), regions, bound.system)
                                        : HandleFields(std::move(groups), regions, rest(), options().field);
        parts = parts_of(rest(), regions, fields, bands_per_handle, labels);
        const int bands = parts.empty() ? 0 : parts.back().first_band + parts.back().band_count();
        const ClusterLoads loads(bound.system.matrix(), rest().points() / unit, labels, bands);
        if (bands > many_bands)
            report.remarks.push_back(std::to_string(bands) +
                                     " bands take long to bind and to solve: use fewer, or join handles");
        eliminate(parts, bound.system, fields.groups(), regions, rest(), diagonal, loads, unit, progress);
        progress.tick(1.0, "bound");
    });
    bound.unit = unit;
    bound.parts = std::move(parts);
    bound.bands = std::move(labels);
    bound.held.clear();
    bound.idle.clear();
    for (int v = 0; v < n; ++v) {
        if (regions.hard(v) >= 0)
            bound.held.push_back({v, regions.hard(v)});
        if (regions.is_idle(v))
            bound.idle.push_back(v);
    }
    bound.system.report(report);
    for (const Part& part : bound.parts)
        report.factor_bytes += part.answers.bytes();
}

namespace {

/// The rigid motion of a handle's surroundings from rest to a shape, for rest points relative to the centre
/// in units of `unit`.
Pose motion_of(const std::vector<int>& patch, const Points& rest, const PointsView& shape,
               const Vector3& centre, double unit)
{
    Vector3 from = Vector3::Zero(), to = Vector3::Zero();
    for (const int v : patch) {
        from += rest.row(v).transpose() / static_cast<double>(patch.size());
        to += shape.row(v).transpose() / static_cast<double>(patch.size());
    }
    Matrix3 S = Matrix3::Zero();
    for (const int v : patch)
        S += (shape.row(v).transpose() - to) * (rest.row(v).transpose() - from).transpose();
    const Matrix3 R = fit_rotation(S);
    Pose motion;
    motion << R, (to - R * (from - centre)) / unit;
    return motion;
}

/// A pose for points relative to the centre in units of `unit`.
Pose about(const Pose& pose, const Vector3& centre, double unit)
{
    Pose moved = pose;
    moved.col(3) = apply(pose, centre) / unit;
    return moved;
}

/// First such a motion, then a pose.
Pose composed(const Pose& pose, const Pose& motion, double unit)
{
    Pose both;
    both << pose.leftCols<3>() * motion.leftCols<3>(), apply(pose, unit * motion.col(3)) / unit;
    return both;
}

/// Fills the right-hand side of the displacements of a shape y, and returns the constant of 2 F.
/// \param turns  R - 1 of each band.
double load(const Binding& bound, const std::vector<Matrix3>& turns, const PointsView& y, RowMatrix& b)
{
    const SparseMatrix& L = bound.system.matrix();
    return parallel_sum(static_cast<int>(y.rows()), [&](int i) {
        const int own = bound.bands[i];
        if (own < 0)
            return 0.0;
        double sum = 0.0;
        Vector3 force = Vector3::Zero();
        for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
            const auto j = it.row();
            if (j == i)
                continue;
            const Vector3 edge = (y.row(i) - y.row(j)).transpose(), turned = turns[own] * edge;
            force -= 0.5 * it.value() * (turned + turns[bound.bands[j]] * edge);
            sum -= 0.5 * it.value() * turned.squaredNorm();
        }
        b.row(i) = force.transpose();
        return sum;
    });
}

/// The points of a part for a state, from rest.
void place(const Part& part, const RotationClusters::State& state, double unit, const Points& rest,
           Frame& frame, Points& positions)
{
    const int n = static_cast<int>(part.vertices.size());
    const bool whole = n == rest.rows();
    const Matrix3 turn = state.mean.leftCols<3>() - Matrix3::Identity();
    const Vector3 move = unit * state.mean.col(3) - part.centre;
    frame.moves.resize(state.poses.rows() + state.turns.rows(), 3);
    frame.moves << unit * state.poses, unit * state.turns;
    frame.moved.resize(n, 3);
    parallel_for(n, [&](int k) {
        const Vector3 p = rest.row(part.vertices[k]).transpose();
        frame.moved.row(k) = (p + (turn * (p - part.centre) + move)).transpose();
    });
    Points& to = whole ? positions : frame.answers;
    to.resize(n, 3);
    part.answers.apply(frame.moves, view(frame.moved), to.data());
    if (!whole)
        parallel_for(n, [&](int k) { positions.row(part.vertices[k]) = frame.answers.row(k); });
}

} // namespace

SolveReport HandleAwareIsolines::deform(const SolveRequest& request, const Targets& targets,
                                        Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const Points& points = rest().points();
    const int most = request.max_iterations.value_or(options().max_iterations);
    const double tolerance = request.tolerance.value_or(options().tolerance);
    const bool from_rest =
        !targets.incoming || std::equal(points.data(), points.data() + points.size(), targets.base().data());
    const auto frame = impl_->frames.take([] { return std::make_unique<Frame>(); });
    SolveReport report{.converged = true};
    const auto settle = [&](const Part& part, RotationClusters::State& state) {
        const RotationClusters::Settled settled = part.clusters->settle(state, most, tolerance);
        report.iterations = std::max(report.iterations, settled.turns);
        report.converged = report.converged && settled.converged;
        report.residual = std::max(report.residual, settled.residual);
        return settled.energy;
    };
    request.progress.tick(0.0, "solving");
    if (from_rest) {
        positions.resize(points.rows(), 3);
        for (const int v : bound.idle)
            positions.row(v) = points.row(v);
        for (const Part& part : bound.parts) {
            Poses poses;
            for (const int handle : part.handles)
                poses.push_back(about(targets.poses[handle], part.centre, bound.unit));
            RotationClusters::State state = part.start(poses);
            report.energy += energy_factor * bound.unit * bound.unit * settle(part, state);
            place(part, state, bound.unit, points, *frame, positions);
        }
        parallel_for(static_cast<int>(bound.held.size()), [&](int k) {
            const auto [vertex, handle] = bound.held[k];
            positions.row(vertex) = targets.position(vertex, handle).transpose();
        });
        return report;
    }

    std::vector<Matrix3> turns; // R - 1 of all bands
    for (const Part& part : bound.parts) {
        Poses before, after;
        for (int s = 0; s < part.part_handle_count(); ++s) {
            const int handle = part.handles[s];
            before.push_back(motion_of(part.patches[s], points, targets.base(), part.centre, bound.unit));
            const bool aims_from_rest = targets.from_rest && (*targets.from_rest)[handle];
            after.push_back(aims_from_rest ? about(targets.poses[handle], part.centre, bound.unit)
                                           : composed(targets.poses[handle], before.back(), bound.unit));
        }
        RotationClusters::State first = part.start(before), last = part.start(after);
        settle(part, first);
        settle(part, last);
        for (int band = 0; band < part.band_count(); ++band)
            turns.emplace_back(last.rotation(band) * first.rotation(band).transpose() - Matrix3::Identity());
    }
    const SolveReport solved = bound.system.solve(
        targets, positions, [&](RowMatrix& b) { return load(bound, turns, targets.base(), b); });
    report.energy = energy_factor * solved.energy;
    return report;
}

std::vector<int> HandleAwareIsolines::bands() const
{
    const AccessLock shared = reading();
    return impl_->bound->bands;
}

void HandleAwareIsolines::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<HandleAwareIsolines&>(other).impl_->bound);
}

} // namespace sinew
