// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/laplacian_editing.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/handles/held_system.h"
#include "native/handles/map_blend.h"
#include "native/operators/rotation_fit.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// How much the mean frame counts in a fit, as a share of the edges of a vertex: it decides where they leave
/// a rotation open.
constexpr double least_frame = 1e-9;

/// Row i of L f, without the rounding errors of values far from zero.
template <class Values>
Vector3 laplacian_at(const SparseMatrix& L, const Values& f, int i)
{
    double sum[3] = {0, 0, 0};
    const double* const own = f.data() + 3 * static_cast<std::ptrdiff_t>(i);
    for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
        const double* const other = f.data() + 3 * it.row();
        for (int axis = 0; axis < 3; ++axis)
            sum[axis] += it.value() * (other[axis] - own[axis]);
    }
    return {sum[0], sum[1], sum[2]};
}

/// The workspace of a frame.
struct Workspace
{
    Points delta;      ///< of the incoming shape
    RowMatrix change;  ///< (n, 3) T delta - delta; zero where no handle touches the part
    RowMatrix blended; ///< (n, MapBlend::numbers)
};

/// The results of a bind.
struct Binding
{
    HeldSystem system;  ///< of L M^-1 L
    HeldSystem poisson; ///< of L, for harmonic fields
    SparseMatrix L;
    VectorX mass;
    Points delta; ///< of the rest shape
    HandleFields fields;
    HandleGroups groups;
    std::vector<std::vector<int>> patches;
    mutable Pool<Workspace> workspaces;

    void differentiate(const PointsView& points, Points& result) const
    {
        const int n = static_cast<int>(points.rows());
        result.resize(n, 3);
        parallel_for(n, [&](int i) { result.row(i) = laplacian_at(L, points, i).transpose() / mass[i]; });
    }
};

} // namespace

struct LaplacianEditing::Impl
{
    LaplacianEditingOptions options;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();

    bool has_fields() const { return options.transforms == LocalTransforms::from_handles; }

    HandleFields fields(HandleGroups groups, const SurfaceMesh& rest, const Regions& regions,
                        const SparseMatrix& L) const
    {
        if (options.field == Field::geodesic)
            return {std::move(groups), regions, rest};
        bound->poisson.factorize(std::make_shared<SparseMatrix>(L), regions);
        return {std::move(groups), regions, bound->poisson};
    }

    /// R of each part.
    std::vector<Matrix3> frames(const std::vector<Matrix3>& maps) const
    {
        const HandleGroups& groups = bound->groups;
        std::vector<Matrix3> frames(groups.count(), Matrix3::Identity());
        for (int g = 0; g < groups.count() && options.mean_frame; ++g) {
            std::vector<Eigen::Quaterniond> turns;
            bool alike = true;
            const Matrix3& first = maps[groups.handles[groups.offsets[g]]];
            for (int seat = groups.offsets[g]; seat < groups.offsets[g + 1]; ++seat) {
                const Matrix3& map = maps[groups.handles[seat]];
                alike = alike && map == first;
                turns.emplace_back(Polar(map).R);
            }
            frames[g] = alike ? Polar(first).R : mean_rotation(turns).toRotationMatrix();
        }
        return frames;
    }

    /// Solves with delta'_v = turned(v, delta_v).
    template <class Turned>
    SolveReport solve(const Targets& targets, const Points& delta, Workspace& work, Points& positions,
                      const Turned& turned) const
    {
        const Binding& own = *bound;
        const int n = static_cast<int>(delta.rows());
        return own.system.solve(targets, positions, [&](RowMatrix& b) {
            const double sum = parallel_sum(n, [&](int v) {
                if (own.groups.group[v] < 0)
                    return 0.0;
                const Vector3 before = delta.row(v).transpose();
                const Vector3 change = turned(v, before) - before;
                work.change.row(v) = change.transpose();
                return own.mass[v] * change.squaredNorm();
            });
            parallel_for(n, [&](int v) { b.row(v) = laplacian_at(own.L, work.change, v).transpose(); });
            return sum;
        });
    }

    /// The rotation of the edges of a vertex from y to x.
    Matrix3 fit(const PointsView& y, const Points& x, int v, const Matrix3& frame) const
    {
        const SparseMatrix& L = bound->L;
        Matrix3 S = Matrix3::Zero();
        double square = 0.0;
        for (SparseMatrix::InnerIterator it(L, v); it; ++it) {
            const Vector3 edge = (y.row(it.row()) - y.row(v)).transpose();
            S += (x.row(it.row()) - x.row(v)).transpose() * edge.transpose();
            square += edge.squaredNorm();
        }
        return fit_rotation(S + least_frame * square * frame);
    }
};

LaplacianEditing::LaplacianEditing(const SurfaceMesh& rest, const LaplacianEditingOptions& options)
    : SurfaceMethod(rest), impl_(std::make_unique<Impl>())
{
    require_at_least(options.refits, 0, "refits");
    impl_->options = options;
}

LaplacianEditing::~LaplacianEditing() = default;
LaplacianEditing::LaplacianEditing(LaplacianEditing&&) noexcept = default;

void LaplacianEditing::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const int n = rest().vertex_count();
    SparseMatrix L;
    VectorX mass;
    {
        const TriangleMetric metric = triangle_metric(rest(), least_area_for_order(2));
        report.degenerate_faces = degenerate_face_count(rest(), metric);
        L = laplacian_matrix(rest(), impl_->options.laplacian, metric);
        mass = divisible_mass(rest(), impl_->options.laplacian, metric);
    }
    auto A = std::make_shared<SparseMatrix>(sparse_product(L, mass.cwiseInverse(), L));
    HandleGroups groups(regions, connected_components(rest()));
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    HandleFields fields;
    progress.tick(0.2, "factorising");
    bound.system.factorize(std::move(A), regions, [&] {
        progress.tick(0.7, "preparing the transformations");
        if (impl_->has_fields())
            fields = impl_->fields(groups, rest(), regions, L);
        progress.tick(1.0, "bound");
    });
    bound.fields = std::move(fields);
    bound.groups = std::move(groups);
    bound.patches = std::move(patches);
    bound.L = std::move(L);
    bound.mass = std::move(mass);
    bound.differentiate(view(rest().points()), bound.delta);
    bound.workspaces.clear(); // idle rows stay zero
    bound.system.report(report);
    BindReport of_fields;
    bound.poisson.report(of_fields);
    report.factorizations += of_fields.factorizations;
    report.analyses += of_fields.analyses;
    report.factor_bytes += of_fields.factor_bytes;
}

SolveReport LaplacianEditing::deform(const SolveRequest& /*request*/, const Targets& targets,
                                     Points& positions) const
{
    const Impl& impl = *impl_;
    const Binding& bound = *impl.bound;
    const LocalTransforms transforms = impl.options.transforms;
    if (transforms == LocalTransforms::none)
        return bound.system.solve(targets, positions);

    const int n = rest().vertex_count();
    const auto work = bound.workspaces.take([&] {
        auto made = std::make_unique<Workspace>();
        made->change = RowMatrix::Zero(n, 3);
        if (impl.has_fields())
            made->blended.resize(n, MapBlend::numbers);
        return made;
    });
    if (targets.incoming)
        bound.differentiate(*targets.incoming, work->delta);
    const Points& delta = targets.incoming ? work->delta : bound.delta;
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const HandleGroups& groups = bound.groups;

    if (transforms == LocalTransforms::from_handles) {
        const MapBlend blend(groups, maps);
        bound.fields.blend(blend.values(), work->blended);
        return impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) {
            return blend.at(groups.group[v], work->blended.row(v).data())(d);
        });
    }

    const std::vector<Matrix3> frames = impl.frames(maps);
    SolveReport report =
        impl.solve(targets, delta, *work, positions,
                   [&](int v, const Vector3& d) -> Vector3 { return frames[groups.group[v]] * d; });
    for (int k = 0; k < impl.options.refits; ++k)
        report = impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) -> Vector3 {
            return impl.fit(targets.base(), positions, v, frames[groups.group[v]]) * d;
        });
    return report;
}

std::vector<std::string> LaplacianEditing::changed_options(const SurfaceMethod& former) const
{
    const LaplacianEditingOptions &own = impl_->options,
                                  &other = static_cast<const LaplacianEditing&>(former).impl_->options;
    return names_of({{"transforms", own.transforms != other.transforms},
                     {"laplacian", own.laplacian != other.laplacian},
                     {"field", own.field != other.field},
                     {"refits", own.refits != other.refits},
                     {"mean_frame", own.mean_frame != other.mean_frame}});
}

bool LaplacianEditing::updates(const std::string& option) const { return option != "laplacian"; }

void LaplacianEditing::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<LaplacianEditing&>(other).impl_->bound);
}

} // namespace sinew
