// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/propagation.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/handles/held_system.h"
#include "native/handles/map_blend.h"
#include "native/operators/laplacian.h"
#include "native/surface/linear/propagation/kernels.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

using RowVector = Eigen::Matrix<double, 1, MapBlend::numbers>;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// The groups, each with one seat more at its end, for the identity, which is handle `handle_count`.
HandleGroups with_identity(const HandleGroups& groups, int handle_count)
{
    HandleGroups all;
    all.group = groups.group;
    for (int g = 0; g < groups.count(); ++g) {
        all.handles.insert(all.handles.end(), groups.handles.begin() + groups.offsets[g],
                           groups.handles.begin() + groups.offsets[g + 1]);
        all.handles.push_back(handle_count);
        all.offsets.push_back(all.seat_count());
    }
    return all;
}

/// How a handle moves in one frame.
struct Motion
{
    Vector3 centre = Vector3::Zero(), move = Vector3::Zero();
    double turning = 0.0; ///< |R S - I|^2
};

/// The results of a bind.
struct Binding
{
    HeldSystem system; ///< of the Laplacian, for harmonic fields
    HandleFields fields;
    HandleGroups with_identity;
    std::vector<Constraint> constraints;
    std::vector<int> held; ///< (n) the handle that holds each vertex, or -1
    std::vector<std::vector<int>> patches;

    std::vector<Motion> motions(const Targets& targets, const std::vector<Matrix3>& maps) const;
};

std::vector<Motion> Binding::motions(const Targets& targets, const std::vector<Matrix3>& maps) const
{
    std::vector<Motion> motions(targets.poses.size());
    std::vector<int> counts(motions.size(), 0);
    const PointsView base = targets.base();
    for (const auto& [vertex, handle] : constraints) {
        const Vector3 y = base.row(vertex).transpose();
        motions[handle].centre += y;
        motions[handle].move += targets.position(vertex, handle) - y;
        ++counts[handle];
    }
    for (std::size_t h = 0; h < motions.size(); ++h) {
        motions[h].centre /= std::max(1, counts[h]);
        motions[h].move /= std::max(1, counts[h]);
        motions[h].turning = (maps[h] - Matrix3::Identity()).squaredNorm();
    }
    return motions;
}

} // namespace

struct Propagation::Impl
{
    PropagationOptions options;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();

    double transfer(double s) const
    {
        const std::vector<double>& t = options.transfer;
        const double place = s * static_cast<double>(t.size() - 1);
        const int last = static_cast<int>(t.size()) - 2,
                  k = static_cast<int>(std::clamp(std::floor(place), 0.0, static_cast<double>(last)));
        return t[k] + (place - k) * (t[k + 1] - t[k]);
    }
};

Propagation::Propagation(const SurfaceMesh& rest, const PropagationOptions& options)
    : SurfaceMethod(rest), impl_(std::make_unique<Impl>())
{
    if (options.transfer.size() < 2 ||
        !std::ranges::all_of(options.transfer, [](double value) { return std::isfinite(value); }))
        throw InvalidOption("transfer: give at least two finite values, at even steps from 0 to 1");
    impl_->options = options;
}

Propagation::~Propagation() = default;
Propagation::Propagation(Propagation&&) noexcept = default;

void Propagation::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    HandleGroups groups(regions, connected_components(rest()));
    HandleGroups all = with_identity(groups, regions.handle_count());
    std::vector<Constraint> constraints = regions.constraints();
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    std::vector<int> held(rest().vertex_count());
    for (int v = 0; v < rest().vertex_count(); ++v)
        held[v] = regions.hard(v);
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    HandleFields fields;
    if (impl_->options.field == Field::harmonic) {
        auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), Discretization::cotan, metric));
        make_weights_positive(*L);
        progress.tick(0.2, "factorising");
        bound.system.factorize(std::move(L), regions, [&] {
            progress.tick(0.7, "computing the fields");
            fields = HandleFields(std::move(groups), regions, bound.system);
            progress.tick(1.0, "bound");
        });
    } else {
        progress.tick(0.2, "measuring distances");
        fields = HandleFields(std::move(groups), regions, rest(), impl_->options.field);
        progress.tick(1.0, "bound");
    }
    bound.fields = std::move(fields);
    bound.with_identity = std::move(all);
    bound.constraints = std::move(constraints);
    bound.held = std::move(held);
    bound.patches = std::move(patches);
    bound.system.report(report);
}

SolveReport Propagation::deform(const SolveRequest& /*request*/, const Targets& targets,
                                Points& positions) const
{
    const Binding& bound = *impl_->bound;
    std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const std::vector<Motion> motions = bound.motions(targets, maps);
    maps.emplace_back(Matrix3::Identity());
    const MapBlend blend(bound.with_identity, maps);
    const HandleGroups& groups = bound.fields.groups();
    const RowMatrix& values = blend.values();
    // What moves each part. The seats of a group of `with_identity` are shifted by it.
    std::vector<PropagatedMotion> moving;
    std::vector<int> seats, begins;
    std::vector<PropagatedPart> parts(groups.count());
    for (int group = 0; group < groups.count(); ++group) {
        begins.push_back(static_cast<int>(moving.size()));
        const RowVector identity = values.row(bound.with_identity.offsets[group + 1] - 1);
        RowVector::Map(parts[group].identity) = identity;
        RowMatrix3::Map(parts[group].mean) = blend.mean(group);
        for (int seat = groups.offsets[group]; seat < groups.offsets[group + 1]; ++seat) {
            const Motion& motion = motions[groups.handles[seat]];
            if (motion.turning == 0 && motion.move.isZero(0))
                continue;
            PropagatedMotion& added = moving.emplace_back();
            RowVector::Map(added.numbers) = values.row(seat + group) - identity;
            Vector3::Map(added.centre) = motion.centre;
            Vector3::Map(added.move) = motion.move;
            added.turning = motion.turning;
            seats.push_back(seat);
        }
        parts[group].count = static_cast<int>(moving.size()) - begins.back();
    }
    for (int group = 0; group < groups.count(); ++group)
        parts[group].motions = moving.data() + begins[group];

    const PointsView base = targets.base();
    const int n = static_cast<int>(base.rows());
    positions.resize(n, 3);
    const auto share = [&](int v, int k) { return impl_->transfer(bound.fields.share(v, seats[k])); };
    const auto move = [&](int v) -> Vector3 {
        const int group = groups.group[v];
        if (group < 0)
            return base.row(v).transpose();
        if (bound.held[v] >= 0)
            return targets.position(v, bound.held[v]);
        const Vector3 y = base.row(v).transpose();
        RowVector nine = RowVector::Map(parts[group].identity);
        Vector3 centre = Vector3::Zero(), shift = Vector3::Zero();
        double turning = 0.0;
        for (int k = begins[group]; k < begins[group] + parts[group].count; ++k) {
            const double t = share(v, k), weight = std::max(0.0, t) * moving[k].turning;
            nine += t * RowVector::Map(moving[k].numbers);
            centre += weight * Vector3::Map(moving[k].centre);
            turning += weight;
            shift += t * Vector3::Map(moving[k].move);
        }
        const Vector3 arm = turning > 0 ? Vector3(y - centre / turning) : Vector3::Zero();
        return y + (blend.at(group, nine.data())(arm) - arm) + shift;
    };
    const PropagationKernels& kernels = widest_kernels<PropagationKernels>();
    parallel_chunks(n, 2048, [&](int begin, int end) {
        std::vector<double> t(4 * moving.size());
        for (int v = begin; v < end; v += 4) {
            const int group = groups.group[v], last = std::min(v + 4, end);
            bool together = last == v + 4 && group >= 0 && !blend.alike(group);
            for (int i = v; together && i < last; ++i) {
                together = groups.group[i] == group && bound.held[i] < 0;
                for (int k = 0; together && k < parts[group].count; ++k)
                    t[4 * k + (i - v)] = share(i, begins[group] + k);
            }
            if (together && kernels.move(parts[group], t.data(), base.row(v).data(), positions.row(v).data()))
                continue;
            for (int i = v; i < last; ++i)
                positions.row(i) = move(i).transpose();
        }
    });
    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.half_turns = blend.half_turns(groups);
    return report;
}

std::vector<std::string> Propagation::changed_options(const SurfaceMethod& former) const
{
    const PropagationOptions& other = static_cast<const Propagation&>(former).impl_->options;
    return names_of({{"field", impl_->options.field != other.field},
                     {"transfer", impl_->options.transfer != other.transfer}});
}

bool Propagation::updates(const std::string& /*option*/) const { return true; }

void Propagation::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<Propagation&>(other).impl_->bound);
}

} // namespace sinew
