// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/rotation_invariant_coordinates.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/handles/constrained_system.h"
#include "native/handles/handle_fields.h"
#include "native/handles/map_blend.h"
#include "native/operators/fits/fit_kernels.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/LU>

#include <algorithm>
#include <utility>

namespace sinew {

namespace {

constexpr double least_determinant = 1e-3; ///< of a mean of rotations that has a closest rotation

using FrameRow = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system; ///< of the Laplacian
    HandleFields fields;
    std::vector<std::vector<int>> patches;
    mutable Pool<RowMatrix> workspaces; ///< (n, 9) the entries of Q - 1, row by row

    /// Q - 1 at every vertex. Returns at how many of them the mean of the rotations has no closest rotation.
    int turn(const std::vector<Matrix3>& maps, RowMatrix& turns) const;
    /// Fills the right-hand side of the displacements from y, and returns the constant of the energy.
    double source(const PointsView& y, const RowMatrix& turns, RowMatrix& b) const;
};

int Binding::turn(const std::vector<Matrix3>& maps, RowMatrix& turns) const
{
    const HandleGroups& groups = fields.groups();
    std::vector<Matrix3> rotations;
    for (const Matrix3& map : maps)
        rotations.push_back(Polar(map).R);
    RowMatrix values(groups.part_handle_count(), 9);
    for (int part_handle = 0; part_handle < groups.part_handle_count(); ++part_handle)
        FrameRow(values.data() + 9 * static_cast<std::ptrdiff_t>(part_handle)) =
            rotations[groups.handles[part_handle]];
    fields.blend(values, turns);
    const MapBlend vectors(groups, rotations);
    const auto decide = [&](int vertex) -> Matrix3 {
        const int g = groups.group[vertex];
        Eigen::Matrix<double, MapBlend::numbers, 1> mean = decltype(mean)::Zero();
        for (int part_handle = groups.offsets[g]; part_handle < groups.offsets[g + 1]; ++part_handle)
            mean += fields.share(vertex, part_handle) * vectors.values().row(part_handle).transpose();
        const MapBlend::Map map = vectors.at(g, mean.data());
        Matrix3 Q;
        for (int axis = 0; axis < 3; ++axis)
            Q.col(axis) = map(Vector3::Unit(axis));
        return Q;
    };
    const FitKernels& kernels = widest_kernels<FitKernels>();
    const int n = static_cast<int>(turns.rows());
    const double decided =
        parallel_sum((n + 3) / 4,
                     [&](int four) {
                         double means[36] = {}, fitted[36], count = 0;
                         const int begin = 4 * four, rows = std::min(4, n - begin);
                         std::copy_n(turns.data() + 9 * static_cast<std::ptrdiff_t>(begin), 9 * rows, means);
                         const int safe = kernels.fit(means, fitted);
                         for (int k = 0; k < rows; ++k) {
                             if (groups.group[begin + k] < 0)
                                 continue;
                             const Matrix3 mean = FrameRow(means + 9 * k);
                             FrameRow own(turns.data() + 9 * static_cast<std::ptrdiff_t>(begin + k));
                             const bool undecided = mean.determinant() < least_determinant;
                             if (undecided)
                                 own = decide(begin + k);
                             else if (safe >> k & 1)
                                 own = FrameRow(fitted + 9 * k);
                             else
                                 own = fit_rotation_svd(mean);
                             own -= Matrix3::Identity();
                             count += undecided;
                         }
                         return count;
                     },
                     512);
    return static_cast<int>(decided);
}

double Binding::source(const PointsView& y, const RowMatrix& turns, RowMatrix& b) const
{
    const SparseMatrix& L = system.matrix();
    return parallel_sum(static_cast<int>(y.rows()), [&](int i) {
        const double* own = turns.data() + 9 * static_cast<std::ptrdiff_t>(i);
        double sum = 0.0;
        Vector3 force = Vector3::Zero();
        for (SparseMatrix::InnerIterator it(L, i); it; ++it) {
            const auto j = it.row();
            if (j == i)
                continue;
            const double* other = turns.data() + 9 * j;
            const double e[3] = {y(i, 0) - y(j, 0), y(i, 1) - y(j, 1), y(i, 2) - y(j, 2)};
            double square = 0.0;
            for (int axis = 0; axis < 3; ++axis) {
                double turned = 0.0;
                for (int k = 0; k < 3; ++k)
                    turned += 0.5 * (own[3 * axis + k] + other[3 * axis + k]) * e[k];
                force[axis] -= it.value() * turned;
                square += turned * turned;
            }
            sum -= 0.5 * it.value() * square; // each edge comes twice
        }
        b.row(i) = force.transpose();
        return sum;
    });
}

} // namespace

struct RotationInvariantCoordinates::Impl
{
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

RotationInvariantCoordinates::RotationInvariantCoordinates(const SurfaceMesh& rest,
                                                           const RotationInvariantCoordinatesOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    if (options.laplacian != Discretization::uniform && options.laplacian != Discretization::cotan)
        throw InvalidOption(std::string("laplacian: '") +
                            (options.laplacian == Discretization::robust ? "robust" : "cotan_voronoi") +
                            "' is not one of 'uniform', 'cotan'");
}

void RotationInvariantCoordinates::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), options().laplacian, metric));
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    HandleFields fields;
    progress.tick(0.2, "factorising");
    bound.system.factorize(std::move(L), regions, [&] {
        progress.tick(0.7, "computing the fields");
        fields = HandleFields(HandleGroups(regions, connected_components(rest())), regions, bound.system);
        progress.tick(1.0, "bound");
    });
    bound.fields = std::move(fields);
    bound.patches = std::move(patches);
    bound.workspaces.clear(); // idle rows stay zero
    bound.system.report(report);
}

SolveReport RotationInvariantCoordinates::deform(const SolveRequest& /*request*/, const Targets& targets,
                                                 Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto turns = bound.workspaces.take(
        [this] { return std::make_unique<RowMatrix>(RowMatrix::Zero(rest().vertex_count(), 9)); });
    int half_turns = 0;
    SolveReport report = bound.system.solve(targets, positions, [&](RowMatrix& b) {
        half_turns = bound.turn(linear_maps(targets, bound.patches), *turns);
        return bound.source(targets.base(), *turns, b);
    });
    report.half_turns = half_turns;
    return report;
}

void RotationInvariantCoordinates::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<RotationInvariantCoordinates&>(other).impl_->bound);
}

} // namespace sinew
