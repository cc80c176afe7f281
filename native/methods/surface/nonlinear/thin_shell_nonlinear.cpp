// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/thin_shell_nonlinear.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/coarse_start.h"
#include "native/local_global/rows/goals.h"
#include "native/local_global/rows/row_problem.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/operators/laplacian.h"
#include "native/operators/painted.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

constexpr double least_stretching = 1e-3; ///< as a share of the largest painted one
/// An energy below this share of that of a sheet shrunk to a point is rounding. Without this floor, rigid
/// poses would iterate on it.
constexpr double rounding_floor = 1e-14;
/// The share of the sheet's bending that smooths the rotations at the start. ARAP with all of it resists
/// twists more than a sheet does: its rotations may not turn within the surface either.
constexpr double smoothing_share = 0.3;
/// Where the sheet hardly stretches, the metric is far stiffer than the energy, so a step may be too long.
constexpr int plain_steps = 4;
/// Linear solves at the start: one more than for a membrane, as bending has a larger condition number.
constexpr int start_solves = 3;

/// k_s and k_b at each vertex.
struct Stiffnesses
{
    std::vector<double> stretching, bending;
};

/// \param unit  that the method computes in.
Stiffnesses stiffnesses(const ThinShellNonlinearOptions& options, const SurfaceMesh& mesh, double unit)
{
    using Measure = ThinShellNonlinearOptions::Measure;
    const int n = mesh.vertex_count();
    const auto numbers = [n](const std::vector<double>& values, double least, const char* name) {
        std::vector<double> all = painted(values, n, least, name);
        return all.empty() ? std::vector<double>(n, 0.0) : all; // zero everywhere
    };
    // Options that do not count with this measure are refused, too, where they mean nothing.
    std::vector<double> thickness = numbers(options.thickness, 0.0, "thickness");
    Stiffnesses k{painted(options.stretching, n, least_stretching, "stretching"),
                  numbers(options.bending, 0.0, "bending")};
    if (options.measure == Measure::stiffness) {
        if (k.stretching.empty())
            throw InvalidOption("stretching: zero everywhere; give at least one vertex a positive value");
        for (double& b : k.bending)
            b /= unit * unit;
        return k;
    }
    const std::vector<double> lengths =
        options.measure == Measure::share ? part_sizes(mesh) : std::vector<double>(n, 1.0);
    for (int v = 0; v < n; ++v)
        thickness[v] = std::pow(thickness[v] * lengths[v] / unit, 2);
    return {std::vector<double>(n, 1.0), std::move(thickness)};
}

/// Two triangles at an edge, or one alone.
struct Hinge
{
    struct Side
    {
        int triangle = -1, corner = 0; ///< the corner opposite the edge
    } sides[2];
    double share = 1.0; ///< of the edge
    bool lone() const { return sides[1].triangle < 0; }
};

/// The pairs of triangles that share an edge, and the triangles that share none. Triangles with fewer than
/// three corners are alone.
std::vector<Hinge> hinges_of(const SurfaceMesh& mesh)
{
    struct Edge
    {
        int low, high;
        Hinge::Side side;
    };
    std::vector<Edge> edges;
    const std::vector<Triangle>& triangles = mesh.triangles();
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
        const auto& [a, b, c] = triangles[t];
        if (a == b || b == c || c == a)
            continue;
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
            edges.push_back({low, high, {t, k}});
        }
    }
    std::ranges::sort(edges, {}, [](const Edge& e) { return std::tuple(e.low, e.high, e.side.triangle); });
    std::vector<Hinge> hinges;
    std::vector<char> paired(triangles.size(), false);
    for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
        end = begin + 1;
        while (end < edges.size() && edges[end].low == edges[begin].low &&
               edges[end].high == edges[begin].high)
            ++end;
        const std::size_t count = end - begin,
                          pairs = count > 2 ? count : count - 1; // a ring, if more than two
        for (std::size_t k = 0; k < pairs; ++k) {
            const Edge &one = edges[begin + k], &other = edges[begin + (k + 1) % count];
            hinges.push_back({{one.side, other.side}, count > 2 ? 0.5 : 1.0});
            paired[one.side.triangle] = paired[other.side.triangle] = true;
        }
    }
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        if (!paired[t])
            hinges.push_back({{{t, 0}, {}}});
    return hinges;
}

/// The table of the energy, which does not depend on handles.
struct Sheet
{
    RowTable rows;
    std::vector<std::array<int, 4>> corners; ///< of each cell; -1 behind the last one of a lone triangle
    std::vector<int> thin; ///< vertices at edges where the mesh resists bending more than the sheet does
    double smoothing = 0.0; ///< alpha A of the ARAP energy that starts a solve
    std::vector<double> rigidity; ///< its cells

    Sheet(const SurfaceMesh& mesh, const Stiffnesses& k)
        : rows(mesh.vertex_count(), 0), rigidity(k.stretching)
    {
        const TriangleMetric metric = triangle_metric(mesh);
        const std::vector<Hinge> hinges = hinges_of(mesh);
        rows = RowTable(mesh.vertex_count(), static_cast<int>(hinges.size()));
        std::vector<char> flat(mesh.triangles().size(), false);
        for (const int t : metric.degenerate)
            flat[t] = true;
        std::vector<int> cells(mesh.triangles().size(), 0);
        for (const Hinge& hinge : hinges)
            for (const Hinge::Side& side : hinge.sides)
                if (side.triangle >= 0)
                    ++cells[side.triangle];
        std::vector<char> is_thin(mesh.vertex_count(), false);
        double bending = 0.0, area = 0.0;
        for (int h = 0; h < static_cast<int>(hinges.size()); ++h) {
            const Hinge& hinge = hinges[h];
            const Triangle& first = mesh.triangles()[hinge.sides[0].triangle];
            double own = 0.0; // resistance of the cell to folding, as a share of A_h^2 / (4 |e|^2)
            for (const Hinge::Side& side : hinge.sides) {
                if (side.triangle < 0)
                    continue;
                const double each = stretching(mesh.triangles()[side.triangle], k) / cells[side.triangle];
                add_membrane(mesh.triangles()[side.triangle], metric.half_cotan[side.triangle], each, h);
                own += 0.5 * each;
            }
            const int corner = hinge.sides[0].corner, a = first[(corner + 1) % 3],
                      b = first[(corner + 2) % 3];
            corners.push_back({first[corner], a, b, -1});
            if (hinge.lone())
                continue;
            const Triangle& second = mesh.triangles()[hinge.sides[1].triangle];
            const int across = second[hinge.sides[1].corner];
            corners.back()[3] = across;
            if (flat[hinge.sides[0].triangle] || flat[hinge.sides[1].triangle])
                continue;
            const double areas = metric.area[hinge.sides[0].triangle] + metric.area[hinge.sides[1].triangle];
            own *= areas * areas / (4 * (mesh.point(a) - mesh.point(b)).squaredNorm());
            const double wanted =
                0.25 * (k.bending[a] + k.bending[b] + k.bending[first[corner]] + k.bending[across]);
            const double k_s = 0.5 * (stretching(first, k) + stretching(second, k));
            bending += areas * std::max(wanted, own) / k_s;
            area += areas;
            if (wanted < own) {
                is_thin[a] = is_thin[b] = true;
                continue;
            }
            const auto cotan = [&](const Hinge::Side& side, int vertex) {
                for (int c = 0; c < 3; ++c)
                    if (mesh.triangles()[side.triangle][c] == vertex)
                        return 2 * metric.half_cotan[side.triangle][c];
                return 0.0;
            };
            const double a1 = cotan(hinge.sides[0], a), b1 = cotan(hinge.sides[0], b),
                         a2 = cotan(hinge.sides[1], a), b2 = cotan(hinge.sides[1], b);
            const RowTable::Term terms[] = {
                {a, b1 + b2}, {b, a1 + a2}, {first[corner], -a1 - b1}, {across, -a2 - b2}};
            rows.add(hinge.share * (wanted - own) / areas, terms, h);
        }
        smoothing = area > 0 ? smoothing_share * 0.5 * bending / area : 0.0;
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (is_thin[v])
                thin.push_back(v);
    }

private:
    static double stretching(const Triangle& t, const Stiffnesses& k)
    {
        return (k.stretching[t[0]] + k.stretching[t[1]] + k.stretching[t[2]]) / 3.0;
    }

    /// The sum of half_cotan |edge|^2 over a triangle's edges, which is A |grad q|^2, as squares with weights
    /// that are not negative.
    void add_membrane(const Triangle& t, const std::array<double, 3>& half_cotan, double weight, int h)
    {
        const double whole = half_cotan[0] + half_cotan[2]; // of (q_1 - q_0)^2; always positive
        const double mixed = -half_cotan[0] / whole;
        const RowTable::Term both[] = {{t[0], -1.0 - mixed}, {t[1], 1.0}, {t[2], mixed}};
        const RowTable::Term other[] = {{t[0], -1.0}, {t[2], 1.0}};
        rows.add(weight * whole, both, h);
        rows.add(weight * (half_cotan[0] + half_cotan[1] - whole * mixed * mixed), other, h);
    }
};

/// The workspace of a solve.
struct Workspace
{
    TargetsInUnit targets;
    Goals goals;
    CoarseStart::Workspace start;
    std::vector<Eigen::Quaterniond> rotations;
    RotationVectors vectors;
    RotationBuffers buffers;
    LbfgsWorkspace descent;
    Points x;
};

/// The results of a bind.
struct Binding
{
    RowSystem cells;
    double rest_scale;
    CoarseStart start;
    mutable Pool<Workspace> workspaces;

    Binding(RowTable rows, const Sheet& sheet, const SurfaceMesh& mesh, const Regions& regions,
            const Progress& progress)
        : cells(with_pulls(rows, regions), mesh.points(), held_vertices(regions)),
          rest_scale(cells.scale(cells.rest_vectors())),
          start(mesh, regions, sheet.smoothing, sheet.rigidity, progress)
    {
    }

private:
    static const RowTable& with_pulls(RowTable& rows, const Regions& regions)
    {
        add_pulls(regions, rows);
        return rows;
    }
};

} // namespace

struct ThinShellNonlinear::Impl
{
    double unit = 1.0; ///< see normal_unit()
    Stiffnesses stiffnesses; ///< in that unit
    Points rest; ///< (n, 3) likewise; empty where the unit is 1
    std::optional<Sheet> sheet;       ///< by the first bind
    int degenerate_faces = 0;         ///< counted by the first bind
    int factorizations = 0;
    std::unique_ptr<const Binding> bound; ///< null before the first bind

    PointsView rest_in_unit(const SurfaceMesh& mesh) const
    {
        return view(unit == 1.0 ? mesh.points() : rest);
    }

    /// Sets the rotations of the cells to means of those of their corners.
    void start_from(const std::vector<Eigen::Quaterniond>& vertices, RowProblem& problem) const
    {
        parallel_for(static_cast<int>(sheet->corners.size()), [&](int h) {
            Matrix3 sum = Matrix3::Zero();
            for (const int v : sheet->corners[h])
                if (v >= 0)
                    sum += vertices[v].toRotationMatrix();
            problem.set_rotation(h, fit_rotation(sum));
        });
    }
};

ThinShellNonlinear::ThinShellNonlinear(const SurfaceMesh& rest, const ThinShellNonlinearOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    impl_->unit = normal_unit(rest.points());
    impl_->stiffnesses = stiffnesses(options, rest, impl_->unit);
}

void ThinShellNonlinear::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Impl& self = *impl_;
    const std::optional<SurfaceMesh> scaled = in_unit(rest(), self.unit);
    const SurfaceMesh& mesh = scaled ? *scaled : rest();
    if (!self.sheet) {
        self.sheet.emplace(mesh, self.stiffnesses);
        self.degenerate_faces = degenerate_face_count(mesh);
        self.rest = scaled ? mesh.points() : Points();
    }
    progress.tick(0.2, "factorising");
    auto next = std::make_unique<const Binding>(self.sheet->rows, *self.sheet, mesh, regions, progress);
    progress.tick(1.0, "bound");

    self.bound = std::move(next);
    ++self.factorizations;
    report.degenerate_faces = self.degenerate_faces;
    report.factorizations = self.factorizations;
    // At the peak, the factor is in double precision still, or the ones of the start are there, too.
    const std::int64_t factor = self.bound->cells.factor_bytes();
    report.factor_bytes = factor + std::max(factor, self.bound->start.factor_bytes());
    report.thin_vertices = self.sheet->thin;
}

void ThinShellNonlinear::swap_binding(SurfaceMethod& other)
{
    Impl& others = *static_cast<ThinShellNonlinear&>(other).impl_;
    std::swap(impl_->rest, others.rest);
    std::swap(impl_->sheet, others.sheet);
    std::swap(impl_->degenerate_faces, others.degenerate_faces);
    std::swap(impl_->factorizations, others.factorizations);
    std::swap(impl_->bound, others.bound);
}

SolveReport ThinShellNonlinear::deform(const SolveRequest& request, const Targets& given,
                                       Points& positions) const
{
    const Impl& self = *impl_;
    const Binding& bound = *self.bound;
    LbfgsOptions options{.max_iterations = request.max_iterations.value_or(this->options().max_iterations),
                         .tolerance = request.tolerance.value_or(this->options().tolerance),
                         .plain_steps = plain_steps};

    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    const Targets targets = work->targets.of(given, self.rest_in_unit(rest()), self.unit);
    work->goals.set(regions(), targets);
    if (bound.cells.free_count() == 0) {
        positions = self.unit * work->goals.held;
        return {.converged = true};
    }
    const RotationVectors* vectors = &bound.cells.rest_vectors();
    if (targets.incoming) {
        bound.cells.set_vectors(*targets.incoming, work->vectors);
        vectors = &work->vectors;
    }
    RowProblem problem(bound.cells, *vectors, work->goals.held, work->goals.pulls, &work->buffers);
    options.floor = rounding_floor * (targets.incoming ? bound.cells.scale(*vectors) : bound.rest_scale);
    if (request.start) {
        work->x = bound.cells.free_rows(*request.start);
        work->x /= self.unit;
    } else {
        bound.start.rotations(targets, work->start, work->rotations);
        self.start_from(work->rotations, problem);
        problem.global_step(work->x, start_solves);
    }
    SolveReport report = minimize(problem, work->x, options, request.progress, &work->descent);
    report.energy *= self.unit * self.unit;
    problem.place(work->x, positions);
    positions *= self.unit;
    return report;
}

double ThinShellNonlinear::energy(const PointsView& positions) const
{
    require_same_size(positions, "positions");
    const AccessLock shared = reading();
    const Impl& self = *impl_;
    if (!self.bound)
        return 0.0;
    const PointsView base = self.rest_in_unit(rest());
    Points all = positions / self.unit;
    for (int v = 0; v < all.rows(); ++v)
        if (regions().is_idle(v))
            all.row(v) = base.row(v);
    Points pulls(static_cast<Eigen::Index>(regions().soft().size()), 3); // to where the vertices are
    for (std::size_t k = 0; k < regions().soft().size(); ++k)
        pulls.row(static_cast<Eigen::Index>(k)) = all.row(regions().soft()[k].vertex);
    RowProblem problem(self.bound->cells, self.bound->cells.rest_vectors(), all, pulls);
    Points gradient;
    return problem.evaluate(self.bound->cells.free_rows(view(all)), gradient) * self.unit * self.unit;
}

} // namespace sinew
