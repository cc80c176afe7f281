// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/laplacian_editing.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/handles/constrained_system.h"
#include "native/handles/map_blend.h"
#include "native/methods/surface/linear/responses/implicit_response.h"
#include "native/operators/differential_coordinates.h"
#include "native/operators/fits/fit_kernels.h"
#include "native/operators/fits/ring_fit.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/solvers/solved_system.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

/// How much the mean frame counts in a fit, as a share of the edges of a vertex: it decides where they leave
/// a rotation open.
constexpr double least_frame = 1e-9;

/// A transformation that shortens a differential coordinate more than this is none.
constexpr double least_length = 1e-9;

/// T d, with the length of d.
Vector3 lengthened(const LinearSimilarity& T, const Vector3& d)
{
    const Vector3 turned = T(d);
    const double length = turned.norm(), before = d.norm();
    return length > least_length * before ? Vector3(before / length * turned) : d;
}

std::vector<Ring> rings_of(const SparseMatrix& L, const PointsView& y)
{
    std::vector<Ring> rings(y.rows());
    parallel_for(static_cast<int>(y.rows()), [&](int v) { rings[v] = ring_at(L, y, v); });
    return rings;
}

using NineOf = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// sum e' e^T over the edges e of a vertex in y, and e' in x.
Matrix3 turned_edges(const SparseMatrix& L, const PointsView& y, const Points& x, int vertex,
                     const Matrix3& frame)
{
    double sum[9] = {}, square = 0.0;
    const double *const before = y.data() + 3 * static_cast<std::ptrdiff_t>(vertex),
                        *const after = x.data() + 3 * static_cast<std::ptrdiff_t>(vertex);
    for (SparseMatrix::InnerIterator it(L, vertex); it; ++it) {
        const double *const from = y.data() + 3 * it.row(), *const to = x.data() + 3 * it.row();
        const double e[3] = {from[0] - before[0], from[1] - before[1], from[2] - before[2]};
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                sum[3 * r + c] += (to[r] - after[r]) * e[c];
        square += e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
    }
    return NineOf(sum) + least_frame * square * frame;
}

/// The workspace of a frame.
struct Workspace
{
    Points delta;      ///< of the incoming shape
    RowMatrix change;  ///< (n, 3) T delta - delta; zero where no handle touches the part
    RowMatrix nine;    ///< (n, 9) blended maps or fitted rotations
    RowMatrix displacements; ///< (3n, 1) of ImplicitResponse
};

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system;  ///< of L M^-1 L
    ConstrainedSystem poisson; ///< of L, for harmonic fields
    SparseMatrix L;
    VectorX mass;
    Points delta; ///< of the rest shape
    HandleFields fields;
    HandleGroups groups;
    std::vector<std::vector<int>> patches;
    std::vector<Ring> rings;                    ///< of the rest shape, for `implicit`
    std::shared_ptr<const ImplicitResponse> first; ///< null unless `implicit`
    std::vector<Handle> first_handles;             ///< that it was made for
    int implicit_factorizations = 0;
    mutable Pool<Workspace> workspaces;
};

} // namespace

struct LaplacianEditing::Impl
{
    explicit Impl(const LaplacianEditingOptions& given) : options(given) {}

    const LaplacianEditingOptions& options;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();

    bool has_fields() const { return options.transforms == LocalTransforms::from_handles; }
    bool is_implicit() const { return options.transforms == LocalTransforms::implicit; }

    HandleFields fields(HandleGroups groups, const SurfaceMesh& rest, const Regions& regions,
                        const SparseMatrix& L) const
    {
        if (options.field != Field::harmonic)
            return {std::move(groups), regions, rest, options.field};
        auto positive = std::make_shared<SparseMatrix>(L);
        make_weights_positive(*positive);
        bound->poisson.factorize(std::move(positive), regions);
        return {std::move(groups), regions, bound->poisson};
    }

    /// R of each part, and in how many vertices of which a rule chose it.
    std::vector<Matrix3> frames(const std::vector<Matrix3>& maps, int& half_turns) const
    {
        const HandleGroups& groups = bound->groups;
        std::vector<Matrix3> frames(groups.count(), Matrix3::Identity());
        for (int g = 0; g < groups.count() && options.mean_frame; ++g) {
            std::vector<Eigen::Quaterniond> turns;
            bool alike = true;
            const Matrix3& first = maps[groups.handles[groups.offsets[g]]];
            for (int part_handle = groups.offsets[g]; part_handle < groups.offsets[g + 1]; ++part_handle) {
                const Matrix3& map = maps[groups.handles[part_handle]];
                alike = alike && map == first;
                turns.emplace_back(Polar(map).R);
            }
            const Eigen::Quaterniond mean = mean_rotation(turns);
            frames[g] = alike ? Polar(first).R : mean.toRotationMatrix();
            if (std::ranges::any_of(turns, [&](const Eigen::Quaterniond& q) { return opposed(mean, q); }))
                half_turns += static_cast<int>(std::ranges::count(groups.group, g));
        }
        return frames;
    }

    std::shared_ptr<const ImplicitResponse> response(const SurfaceMesh& rest, const Regions& regions,
                                                     const HandleGroups& groups, const SparseMatrix& L,
                                                     const VectorX& mass, const std::vector<Ring>& rings,
                                                     const Points& delta) const
    {
        ++bound->implicit_factorizations;
        return std::make_shared<ImplicitResponse>(rest, L, mass, rings, delta, regions, groups);
    }

    SolveReport described(const SolveReport& report) const
    {
        if (SolvedSystem* const solved = SolvedSystem::of_thread())
            solved->describe(bound->L, bound->mass, 2);
        return report;
    }

    /// Solves with delta'_v = turned(v, delta_v).
    template <class Turned>
    SolveReport solve(const Targets& targets, const Points& delta, Workspace& work, Points& positions,
                      const Turned& turned) const
    {
        const Binding& own = *bound;
        const int n = static_cast<int>(delta.rows());
        return described(own.system.solve(targets, positions, [&](RowMatrix& b) {
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
        }));
    }

    /// (n, 9) the rotations of the edges at each vertex from y to x, row by row.
    void fit(const PointsView& y, const Points& x, const std::vector<Matrix3>& frames,
             RowMatrix& rotations) const
    {
        const FitKernels& kernels = widest_kernels<FitKernels>();
        const int n = static_cast<int>(y.rows());
        parallel_for((n + 3) / 4,
                     [&](int four) {
                         double sums[36] = {}, fitted[36];
                         const int begin = 4 * four, rows = std::min(4, n - begin);
                         for (int k = 0; k < rows; ++k)
                             if (const int g = bound->groups.group[begin + k]; g >= 0)
                                 NineOf(sums + 9 * k) = turned_edges(bound->L, y, x, begin + k, frames[g]);
                         const int safe = kernels.fit(sums, fitted);
                         for (int k = 0; k < rows; ++k)
                             if (!(safe >> k & 1))
                                 NineOf(fitted + 9 * k) = fit_rotation_svd(NineOf(sums + 9 * k));
                         std::copy_n(fitted, 9 * rows,
                                     rotations.data() + 9 * static_cast<std::ptrdiff_t>(begin));
                     },
                     512);
    }
};

LaplacianEditing::LaplacianEditing(const SurfaceMesh& rest, const LaplacianEditingOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>(this->options()))
{
}

SurfaceMethod::Stepping LaplacianEditing::stepping() const
{
    switch (options().transforms) {
    case LocalTransforms::from_handles:
        return Stepping::none;
    case LocalTransforms::estimated:
        return Stepping::from_last;
    default:
        return Stepping::anew;
    }
}

bool LaplacianEditing::displaces_all_alike() const { return options().transforms == LocalTransforms::none; }

std::unique_ptr<SurfaceMethod> LaplacianEditing::made_anew(const SurfaceMesh& rest) const
{
    return std::make_unique<LaplacianEditing>(rest, options());
}

void LaplacianEditing::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    SparseMatrix L;
    VectorX mass;
    {
        const TriangleMetric metric = triangle_metric(rest(), least_area_for_order(2));
        report.degenerate_faces = degenerate_face_count(rest(), metric);
        L = laplacian_matrix(rest(), options().laplacian, metric);
        mass = divisible_mass(rest(), options().laplacian, metric);
    }
    auto A = std::make_shared<SparseMatrix>(sparse_product(L, mass.cwiseInverse(), L));
    HandleGroups groups(regions, connected_components(rest()));
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    Points delta;
    differentiate(L, mass, view(rest().points()), delta);
    HandleFields fields;
    std::vector<Ring> rings;
    std::shared_ptr<const ImplicitResponse> first;
    progress.tick(0.2, "factorising");
    bound.system.factorize(std::move(A), regions, [&] {
        progress.tick(impl_->is_implicit() ? 0.25 : 0.7, "preparing the transformations");
        if (impl_->has_fields())
            fields = impl_->fields(groups, rest(), regions, L);
        if (impl_->is_implicit()) {
            rings = rings_of(L, view(rest().points()));
            const bool same = bound.first && bound.first_handles == regions.handles();
            first = same ? bound.first : impl_->response(rest(), regions, groups, L, mass, rings, delta);
        }
        progress.tick(1.0, "bound");
    });
    bound.first_handles = first ? regions.handles() : std::vector<Handle>();
    bound.first = std::move(first);
    bound.rings = std::move(rings);
    bound.fields = std::move(fields);
    bound.groups = std::move(groups);
    bound.patches = std::move(patches);
    bound.L.swap(L); // the move assignment of Eigen's sparse matrices would copy
    bound.mass = std::move(mass);
    bound.delta = std::move(delta);
    bound.workspaces.clear(); // idle rows stay zero
    bound.system.report(report);
    BindReport of_fields;
    bound.poisson.report(of_fields);
    report.factorizations += of_fields.factorizations + bound.implicit_factorizations;
    report.analyses += of_fields.analyses + bound.implicit_factorizations;
    report.factor_bytes += of_fields.factor_bytes + (bound.first ? bound.first->bytes() : 0);
}

SolveReport LaplacianEditing::deform(const SolveRequest& request, const Targets& targets,
                                     Points& positions) const
{
    const Impl& impl = *impl_;
    const Binding& bound = *impl.bound;
    const LocalTransforms transforms = impl.options.transforms;
    if (transforms == LocalTransforms::none)
        return impl.described(bound.system.solve(targets, positions));

    const int n = rest().vertex_count();
    const auto work = bound.workspaces.take([&] {
        auto made = std::make_unique<Workspace>();
        made->change = RowMatrix::Zero(n, 3);
        made->nine.resize(n, MapBlend::numbers);
        return made;
    });
    if (targets.incoming)
        differentiate(bound.L, bound.mass, *targets.incoming, work->delta);
    const Points& delta = targets.incoming ? work->delta : bound.delta;
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const HandleGroups& groups = bound.groups;

    if (transforms == LocalTransforms::from_handles) {
        const MapBlend blend(groups, maps);
        bound.fields.blend(blend.values(), work->nine);
        SolveReport report =
            impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) -> Vector3 {
                return blend.at(groups.group[v], work->nine.data() + 9 * static_cast<std::ptrdiff_t>(v))(d);
            });
        report.half_turns = blend.half_turns(groups);
        return report;
    }

    int half_turns = 0;
    const std::vector<Matrix3> frames = impl.frames(maps, half_turns);
    SolveReport report;
    if (impl.is_implicit()) {
        const PointsView y = targets.base();
        bound.first->displace(targets, frames, work->displacements);
        report = impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) -> Vector3 {
            const Ring ring = targets.incoming ? ring_at(bound.L, y, v) : bound.rings[v];
            const LinearSimilarity T = fit_ring(bound.L, y, ring, work->displacements.data(), v);
            return frames[groups.group[v]] *
                   (impl.options.second_stage == SecondStage::length ? lengthened(T, d) : T.rotated(d));
        });
    } else {
        // Other starts are for iterative methods.
        const bool has_last = request.start && request.substeps > 1;
        report = impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) -> Vector3 {
            return has_last ? Vector3(laplacian_at(bound.L, *request.start, v) / bound.mass[v])
                            : Vector3(frames[groups.group[v]] * d);
        });
        for (int k = 0; k < impl.options.refits; ++k) {
            impl.fit(targets.base(), positions, frames, work->nine);
            report = impl.solve(targets, delta, *work, positions, [&](int v, const Vector3& d) -> Vector3 {
                return NineOf(work->nine.data() + 9 * static_cast<std::ptrdiff_t>(v)) * d;
            });
        }
    }
    report.half_turns = half_turns;
    return report;
}

void LaplacianEditing::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<LaplacianEditing&>(other).impl_->bound);
}

} // namespace sinew
