// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/spline_surface.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/handles/constrained_system.h"
#include "native/mesh/frames/principal_frame.h"
#include "native/methods/surface/linear/responses/affine_basis.h"
#include "native/operators/geodesic_distance.h"
#include "native/operators/laplacian.h"
#include "native/splines/spline_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sinew {

namespace {

constexpr int most_basis_handles = 16;
constexpr int most_fitted = 4096; ///< vertices that the grid at rest is fitted to
constexpr double least_rest_smoothing = 1e-3; ///< of the grid at rest, which is only shown

/// The region of each part: its free vertices, and the held ones that the margin reaches.
std::vector<std::vector<int>> regions_of_parts(const SurfaceMesh& rest, const Regions& regions,
                                               const Components& parts, double margin)
{
    std::vector<std::vector<int>> of_part(parts.count);
    std::vector<Vector3> centres(parts.count, Vector3::Zero());
    std::vector<double> counts(parts.count, 0.0), sizes(parts.count, 0.0);
    std::vector<GeodesicDistance::Source> free;
    for (int v = 0; v < rest.vertex_count(); ++v)
        if (regions.is_free(v)) {
            free.push_back({v});
            centres[parts.labels[v]] += rest.point(v);
            ++counts[parts.labels[v]];
        }
    for (const auto& [v, distance] : free) {
        const int part = parts.labels[v];
        sizes[part] = std::max(sizes[part], 2 * (rest.point(v) - centres[part] / counts[part]).norm());
    }
    if (free.empty())
        return of_part;
    std::vector<bool> inside(rest.vertex_count(), false);
    for (int f = 0; f < rest.face_count(); ++f)
        if (std::ranges::any_of(rest.face(f), [&](int v) { return regions.is_free(v); }))
            for (int v : rest.face(f))
                inside[v] = true;
    const std::vector<double> distance = GeodesicDistance(rest).from(free);
    for (int v = 0; v < rest.vertex_count(); ++v) {
        const int part = parts.labels[v];
        if (inside[v] || distance[v] <= margin * sizes[part]) // infinite where no vertex is free
            of_part[part].push_back(v);
    }
    return of_part;
}

/// The spline over one part.
struct Patch
{
    std::vector<int> vertices; ///< its region
    std::vector<SplineGrid::Stencil> stencils; ///< of the region
    std::vector<Eigen::Index> rows; ///< of Regions::constraints() that move the grid
    ControlFit fit;
    std::vector<int> fitted; ///< vertices that the grid at rest is fitted to
    ControlFit rest;

    /// (size, m) the motions of the control points.
    /// \param wanted  (c, m) one row for each of the constraints of all parts.
    /// \param load    gets (m, m) D^T W D for the rows D of this part.
    RowMatrix control(const RowMatrix& wanted, MatrixX& load) const
    {
        const RowMatrix own = wanted(rows, Eigen::all);
        load += transposed_product(own, fit.weights().asDiagonal() * own);
        return fit.solve(own);
    }
    /// (m, m) R^T W R for R = B c - D.
    MatrixX missed(const RowMatrix& control, const RowMatrix& wanted) const
    {
        const RowMatrix gap = fit.rows() * control - wanted(rows, Eigen::all);
        return transposed_product(gap, fit.weights().asDiagonal() * gap);
    }
};

/// The results of a bind.
struct Binding
{
    SplineGrid grid;
    ConstrainedSystem system; ///< of the harmonic field
    SparseMatrix L; ///< of the system, without the pulls of soft handles
    std::vector<Constraint> constraints;
    std::size_t hard = 0; ///< of the constraints
    std::vector<Patch> patches;
    std::unique_ptr<AffineBasis> basis;

    explicit Binding(const SplineGrid& over) : grid(over) {}

    struct Frame
    {
        RowMatrix spline, wanted;
    };
    std::unique_ptr<Pool<Frame>> frames = std::make_unique<Pool<Frame>>();

    /// The moves of a request; null if there are none.
    /// \throw InvalidConstraint  not one for each control point, or one is not finite.
    const PointsView* moves(const SolveRequest& request) const
    {
        const GridMoves* given = std::get_if<GridMoves>(&request.extra);
        if (!given)
            return nullptr;
        const auto count = static_cast<Eigen::Index>(patches.size()) * grid.size();
        if (given->moves.rows() != count)
            throw InvalidConstraint("grid: " + std::to_string(given->moves.rows()) + " moves given for " +
                                    std::to_string(count) + " control points");
        if (!all_finite(given->moves))
            throw InvalidConstraint("grid: NaN or infinite moves");
        return given->moves.isZero(0) ? nullptr : &given->moves;
    }

    /// (c, 3) what the handles ask of each constraint.
    void read(const Targets& targets, RowMatrix& wanted) const
    {
        wanted.resize(static_cast<Eigen::Index>(constraints.size()), 3);
        for (std::size_t row = 0; row < constraints.size(); ++row) {
            const auto [vertex, handle] = constraints[row];
            wanted.row(static_cast<Eigen::Index>(row)) =
                targets.position(vertex, handle).transpose() - targets.base().row(vertex);
        }
    }

    /// What the spline does where the handles want `wanted` (c, m).
    /// \param[in,out] spline  (n, m) its displacements; in held vertices that no grid covers, what is wanted;
    ///   rows of parts without handles stay.
    /// \param[out] missed, load  (m, m) inner products of what it missed, and of what was wanted.
    /// \param moves  (g, m) what is added to the control points of all patches; nothing if it is null.
    void follow(const RowMatrix& wanted, RowMatrix& spline, MatrixX& missed, MatrixX& load,
                const PointsView* moves = nullptr) const
    {
        missed = load = MatrixX::Zero(wanted.cols(), wanted.cols());
        for (std::size_t row = 0; row < hard; ++row)
            spline.row(constraints[row].vertex) = wanted.row(static_cast<Eigen::Index>(row));
        Eigen::Index first = 0; // point of the patch
        for (const Patch& patch : patches) {
            RowMatrix control = patch.control(wanted, load);
            missed += patch.missed(control, wanted);
            if (moves)
                control += moves->middleRows(first, grid.size());
            first += grid.size();
            parallel_for(static_cast<int>(patch.vertices.size()), [&](int i) {
                grid.evaluate(patch.stencils[i], control, &spline(patch.vertices[i], 0));
            });
        }
    }
};

} // namespace

struct SplineSurface::Impl
{
    const SplineSurfaceOptions& options;
    SplineGrid grid;
    std::unique_ptr<Binding> bound;

    explicit Impl(const SplineSurfaceOptions& given)
        : options(given), grid(given.degree, std::max(given.columns, given.degree + 1),
                               std::max(given.rows, given.degree + 1)),
          bound(std::make_unique<Binding>(grid))
    {
    }

    /// (k, 2) places of vertices, from 0 to 1 in both directions.
    /// \param towards  a direction for the first axis of a plane whose axes are open.
    Eigen::MatrixX2d places(const SurfaceMesh& rest, const std::vector<int>& vertices,
                            const Vector3& towards) const
    {
        Eigen::MatrixX2d uv(static_cast<Eigen::Index>(vertices.size()), 2);
        if (options.uv_map.size() > 0) {
            std::vector<int> without;
            for (Eigen::Index i = 0; i < uv.rows(); ++i) {
                uv.row(i) = options.uv_map.row(vertices[i]);
                if (!uv.row(i).allFinite())
                    without.push_back(vertices[i]);
            }
            if (!without.empty())
                throw InvalidOption("uv_map: no place on the UV map for the vertices " + list_some(without) +
                                        ": unwrap their faces, or choose another map",
                                    Error::Element::vertex, without);
        } else {
            const PrincipalFrame frame = principal_frame(rest.points(), vertices, towards);
            for (Eigen::Index i = 0; i < uv.rows(); ++i)
                uv.row(i) = frame.seen(rest.point(vertices[i])).head<2>().transpose();
        }
        const Eigen::RowVector2d low = uv.colwise().minCoeff(), high = uv.colwise().maxCoeff();
        const double size = (high - low).maxCoeff();
        for (int axis : {0, 1}) {
            const double length = high[axis] - low[axis];
            if (length > 1e-12 * size) // else all are in one line
                uv.col(axis) = (uv.col(axis).array() - low[axis]) / length;
            else
                uv.col(axis).setConstant(0.5);
        }
        return uv;
    }

    Patch patch(const SurfaceMesh& rest, std::vector<int> vertices,
                const std::vector<Constraint>& constraints, const Regions& regions) const
    {
        std::vector<int> index_of(rest.vertex_count(), -1);
        for (std::size_t i = 0; i < vertices.size(); ++i)
            index_of[vertices[i]] = static_cast<int>(i);
        std::vector<Eigen::Index> rows;
        std::vector<int> counts(regions.handle_count(), 0);
        std::vector<Vector3> sums(regions.handle_count(), Vector3::Zero());
        int first = regions.handle_count(), last = -1; // handles
        for (std::size_t row = 0; row < constraints.size(); ++row)
            if (const auto [vertex, handle] = constraints[row]; index_of[vertex] >= 0) {
                rows.push_back(static_cast<Eigen::Index>(row));
                ++counts[handle];
                sums[handle] += rest.point(vertex);
                first = std::min(first, handle);
                last = std::max(last, handle);
            }
        const Eigen::MatrixX2d uv =
            places(rest, vertices, sums[last] / counts[last] - sums[first] / counts[first]);
        std::vector<SplineGrid::Stencil> stencils, held;
        for (Eigen::Index i = 0; i < uv.rows(); ++i)
            stencils.push_back(grid.stencil(uv(i, 0), uv(i, 1)));
        for (Eigen::Index row : rows)
            held.push_back(stencils[index_of[constraints[row].vertex]]);
        const std::size_t hard = constraints.size() - regions.soft().size();
        VectorX weights(static_cast<Eigen::Index>(rows.size()));
        for (Eigen::Index i = 0; i < weights.size(); ++i) {
            const auto row = static_cast<std::size_t>(rows[i]);
            weights[i] =
                (row < hard ? 1.0 : regions.soft()[row - hard].weight) / counts[constraints[row].handle];
        }
        std::vector<int> fitted;
        std::vector<SplineGrid::Stencil> at;
        const std::size_t step = (vertices.size() + most_fitted - 1) / most_fitted;
        for (std::size_t i = 0; i < vertices.size(); i += step) {
            fitted.push_back(vertices[i]);
            at.push_back(stencils[i]);
        }
        const MatrixX bending = grid.bending();
        return {std::move(vertices),
                std::move(stencils),
                std::move(rows),
                ControlFit(grid.weights(held), weights, bending, options.smoothing),
                std::move(fitted),
                ControlFit(grid.weights(at), VectorX::Ones(static_cast<Eigen::Index>(at.size())), bending,
                           std::max(options.smoothing, least_rest_smoothing))};
    }
};

SplineSurface::SplineSurface(const SurfaceMesh& rest, const SplineSurfaceOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>(this->options()))
{
    const RowMatrix& uv = options.uv_map;
    if (uv.size() > 0 && (uv.rows() != rest.vertex_count() || uv.cols() != 2))
        throw InvalidOption("uv_map: (" + std::to_string(uv.rows()) + ", " + std::to_string(uv.cols()) +
                            ") numbers given for " + std::to_string(rest.vertex_count()) + " vertices");
    if ((uv.array().abs() == std::numeric_limits<double>::infinity()).any())
        throw InvalidOption("uv_map: infinite numbers");
}

void SplineSurface::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    const Impl& impl = *impl_;
    auto made = std::make_unique<Binding>(impl.grid);
    made->constraints = regions.constraints();
    made->hard = made->constraints.size() - regions.soft().size();
    const Components parts = connected_components(rest());
    std::vector<std::vector<int>> of_parts = regions_of_parts(rest(), regions, parts, impl.options.margin);
    for (std::vector<int>& vertices : of_parts)
        if (!vertices.empty())
            made->patches.push_back(impl.patch(rest(), std::move(vertices), made->constraints, regions));

    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    auto L = std::make_shared<SparseMatrix>(laplacian_matrix(rest(), Discretization::cotan, metric));
    make_weights_positive(*L);
    made->L = *L;
    progress.tick(0.2, "factorising");
    ConstrainedSystem& system = impl_->bound->system; // which can use an earlier factor again
    system.factorize(std::move(L), regions, [&] {
        progress.tick(0.7, "computing the basis");
        if (regions.handle_count() <= most_basis_handles) {
            const RowMatrix wanted = AffineBasis::columns(rest().points(), regions);
            RowMatrix spline = RowMatrix::Zero(rest().vertex_count(), wanted.cols());
            MatrixX missed, load;
            made->follow(wanted, spline, missed, load);
            MatrixX gap = wanted;
            for (std::size_t row = 0; row < made->constraints.size(); ++row)
                gap.row(static_cast<Eigen::Index>(row)) -= spline.row(made->constraints[row].vertex);
            LinearResponse response = system.respond(gap);
            response.displacement += spline;
            for (std::size_t row = 0; row < made->hard; ++row)
                response.displacement.row(made->constraints[row].vertex) =
                    wanted.row(static_cast<Eigen::Index>(row));
            response.residual = missed;
            response.load = load;
            made->basis = std::make_unique<AffineBasis>(rest().points(), response, regions);
        }
        progress.tick(1.0, "bound");
    });
    std::swap(made->system, system);
    impl_->bound = std::move(made);
    impl_->bound->system.report(report);
}

SolveReport SplineSurface::deform(const SolveRequest& request, const Targets& targets,
                                  Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const PointsView* moves = bound.moves(request);
    if (bound.basis && !request.incoming && !moves)
        return bound.basis->solve(request.poses, positions, !idle_parts_ride());
    const auto frame = bound.frames->take([&] {
        auto kept = std::make_unique<Binding::Frame>();
        kept->spline = RowMatrix::Zero(rest().vertex_count(), 3);
        return kept;
    });
    bound.read(targets, frame->wanted);
    MatrixX missed, load;
    bound.follow(frame->wanted, frame->spline, missed, load, moves);
    // The field that is spread is d - spline, with its Dirichlet energy.
    SolveReport report = bound.system.solve(targets, positions, [&](RowMatrix& b) {
        b.noalias() = bound.L * frame->spline;
        return frame->spline.cwiseProduct(b).sum();
    });
    report.residual = load.trace() > 0 ? std::sqrt(missed.trace() / load.trace()) : 0.0;
    return report;
}

std::vector<SplineSurface::Grid> SplineSurface::control_grids(const SolveRequest& request) const
{
    const AccessLock shared = reading();
    const Targets targets{request.poses, view(rest().points()), request.incoming,
                          request.from_rest ? &*request.from_rest : nullptr};
    targets.check(regions().handle_count());
    const Binding& bound = *impl_->bound;
    const PointsView* moves = bound.moves(request);
    RowMatrix wanted;
    bound.read(targets, wanted);
    std::vector<Grid> grids;
    Eigen::Index first = 0; // point of the patch
    for (const Patch& patch : bound.patches) {
        MatrixX load = MatrixX::Zero(3, 3);
        const RowMatrix at = targets.base()(patch.fitted, Eigen::all);
        Points points = patch.rest.solve(at) + patch.control(wanted, load);
        if (moves)
            points += moves->middleRows(first, bound.grid.size());
        first += bound.grid.size();
        grids.push_back({bound.grid.columns(), bound.grid.rows(), std::move(points)});
    }
    return grids;
}

void SplineSurface::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<SplineSurface&>(other).impl_->bound);
}

} // namespace sinew
