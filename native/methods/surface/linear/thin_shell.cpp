// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "native/core/errors.h"
#include "native/core/progress_part.h"
#include "native/operators/painted.h"
#include "native/solvers/solved_system.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr int most_basis_handles = 16; ///< 64 columns: 0.5 KB per vertex
constexpr double least_painted = 1e-6; ///< the least painted value, as a share of the largest

double mean_over(const std::vector<double>& values, std::span<const int> vertices)
{
    double sum = 0.0;
    for (int v : vertices)
        sum += values[v];
    return sum / static_cast<double>(vertices.size());
}

/// C in the header.
double bending_continuity(const Regions& regions, int vertex)
{
    const int handle = regions.hard(vertex);
    return handle < 0 ? 1.0 : std::min(regions.continuity(handle), 1.0);
}

/// The factor of an element in L_kv.
double variation_continuity(const Regions& regions, std::span<const int> vertices)
{
    double least = 1.0;
    for (int v : vertices) {
        if (regions.hard(v) < 0)
            return 1.0;
        least = std::min(least, std::max(regions.continuity(regions.hard(v)) - 1.0, 0.0));
    }
    return least;
}

/// The three stiffnesses, one value per vertex. Where one is empty, its term is left out.
struct Coefficients
{
    std::vector<double> stretching, bending, variation;
};

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system;
    std::unique_ptr<AffineBasis> basis;
};

} // namespace

struct ThinShell::Impl
{
    const SurfaceMesh& rest;
    Coefficients k;
    Binding bound;

    Impl(const SurfaceMesh& mesh, const ThinShellOptions& given)
        : rest(mesh), k(coefficients(given.stretching, given.bending, given.variation))
    {
    }

    Coefficients coefficients(const Stiffness& stretching, const Stiffness& bending,
                              const Stiffness& variation) const
    {
        const int n = rest.vertex_count();
        Coefficients k{painted(stretching, n, least_painted, "stretching"),
                       painted(bending, n, least_painted, "bending"),
                       painted(variation, n, least_painted, "variation")};
        if (k.stretching.empty() && k.bending.empty() && k.variation.empty())
            throw InvalidOption("stretching, bending and variation are all zero; "
                                "give at least one of them a positive value");
        return k;
    }

    /// The least area of triangles that the term of the highest order needs.
    double least_area() const
    {
        return least_area_for_order(!k.variation.empty() ? 3 : !k.bending.empty() ? 2 : 1);
    }

    /// A in the header, without soft terms.
    std::shared_ptr<SparseMatrix> assemble(const Regions& regions, const TriangleMetric& metric,
                                           Discretization of) const
    {
        const int n = rest.vertex_count();
        const auto laplacian = [&](const ElementScale& scale) {
            return laplacian_matrix(rest, of, metric, scale);
        };
        auto sum = std::make_shared<SparseMatrix>(n, n);
        SparseMatrix& A = *sum;
        const auto add = [&A](SparseMatrix&& term) {
            if (A.nonZeros() == 0)
                A.swap(term); // the move assignment of Eigen's sparse matrices would copy
            else
                A += term;
        };
        if (!k.stretching.empty())
            add(laplacian([&](std::span<const int> element) { return mean_over(k.stretching, element); }));
        if (k.bending.empty() && k.variation.empty())
            return sum;

        const SparseMatrix L = laplacian({});
        VectorX CM = divisible_mass(rest, of, metric).cwiseInverse();
        for (int i = 0; i < n; ++i)
            CM[i] *= bending_continuity(regions, i);
        if (!k.bending.empty())
            add(sparse_product(L, CM.cwiseProduct(Eigen::Map<const VectorX>(k.bending.data(), n)), L));
        if (!k.variation.empty()) {
            const VectorX ones = VectorX::Ones(n);
            const SparseMatrix U = CM.asDiagonal() * L;
            const SparseMatrix L_kv = laplacian([&](std::span<const int> element) {
                return mean_over(k.variation, element) * variation_continuity(regions, element);
            });
            add(sparse_product(U.transpose(), ones, sparse_product(L_kv, ones, U)));
        }
        return sum;
    }

    /// What the matrix is made of.
    LinearSystem parts(const Regions& regions, const TriangleMetric& metric, Discretization of) const
    {
        LinearSystem system;
        const auto& s = k.stretching;
        system.graph = laplacian_matrix(rest, of, metric);
        system.mass = divisible_mass(rest, of, metric);
        for (int i = 0; i < rest.vertex_count() && !k.bending.empty(); ++i)
            system.mass[i] /= k.bending[i] * bending_continuity(regions, i);
        system.order = k.variation.empty() ? 2 : 3;
        if (!s.empty()) // where it is painted, the membrane is its mean
            system.membrane = std::accumulate(s.begin(), s.end(), 0.0) / static_cast<double>(s.size());
        return system;
    }

    /// Says what the matrix is made of.
    void describe(const Regions& regions, Discretization of, SolvedSystem& solved) const
    {
        if (k.bending.empty() && k.variation.empty())
            return;
        LinearSystem system = parts(regions, triangle_metric(rest, least_area()), of);
        solved.describe(system.graph, std::move(system.mass), system.order, system.membrane);
    }

    /// Why the multigrid cannot solve this; empty where it can.
    std::string unsuited() const
    {
        if (!k.variation.empty())
            return "variation must be 0 for the multigrid";
        const auto [least, most] = std::ranges::minmax_element(k.stretching);
        if (!k.bending.empty() && !k.stretching.empty() && *least != *most)
            return "stretching cannot be painted beside bending for the multigrid";
        return {};
    }

    TriangleMetric metric_of(BindReport& report) const
    {
        TriangleMetric metric = triangle_metric(rest, least_area());
        report.degenerate_faces = degenerate_face_count(rest, metric);
        return metric;
    }

    void iterate(Discretization of, const Regions& regions, BindReport& report, const Progress& progress)
    {
        LinearSystem system;
        if (!k.bending.empty())
            system = parts(regions, metric_of(report), of);
        else
            system.graph = laplacian_matrix(rest, of, metric_of(report), [&](std::span<const int> element) {
                return mean_over(k.stretching, element);
            });
        system.points = rest.points();
        progress.tick(0.2, "building the multigrid");
        bound.system.iterate(std::move(system), regions, part_of(progress, 0.2, 1.0),
                             [&] { progress.tick(1.0, "bound"); });
        bound.basis.reset();
    }

    /// The factor is used again where the pattern of the matrix is the same.
    void factorize(const ThinShellOptions& options, const Regions& regions, BindReport& report,
                   const Progress& progress)
    {
        std::shared_ptr<SparseMatrix> A = assemble(regions, metric_of(report), options.laplacian);
        progress.tick(0.2, "factorising");
        std::unique_ptr<AffineBasis> basis;
        bound.system.factorize(std::move(A), regions, [&] {
            progress.tick(0.7, "computing the basis");
            if (options.affine_basis && regions.handle_count() <= most_basis_handles) {
                const MatrixX columns = AffineBasis::columns(rest.points(), regions);
                basis = std::make_unique<AffineBasis>(rest.points(), bound.system.respond(columns), regions);
            }
            progress.tick(1.0, "bound");
        });
        bound.basis = std::move(basis);
    }

    void bind(const ThinShellOptions& options, const Regions& regions, BindReport& report,
              const Progress& progress)
    {
        const auto free = static_cast<int>(std::ranges::count(regions.free_vertices(), true));
        const std::string why =
            bind_by(options.solver, {free, factor_bytes(free, k.bending.empty() ? 1 : 2), unsuited(),
                                     [&] { factorize(options, regions, report, progress); },
                                     [&] { iterate(options.laplacian, regions, report, progress); }});
        bound.system.report(report, why);
    }
};

ThinShell::ThinShell(const SurfaceMesh& rest, const ThinShellOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>(this->rest(), options))
{
}

std::unique_ptr<SurfaceMethod> ThinShell::made_anew(const SurfaceMesh& rest) const
{
    ThinShellOptions options = this->options();
    options.affine_basis = false;
    return std::make_unique<ThinShell>(rest, options);
}

void ThinShell::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    impl_->bind(options(), regions, report, progress);
}

BindReport ThinShell::set_stiffness(const Stiffness& stretching, const Stiffness& bending,
                                    const Stiffness& variation, const Progress& progress)
{
    const AccessLock alone = changing();
    struct Exchange ///< exchanges the stiffnesses, and exchanges them back unless all went well
    {
        ThinShell& own;
        std::shared_ptr<const ThinShellOptions> options;
        Coefficients k;
        bool done = false;

        void swap()
        {
            own.options_.swap(options);
            std::swap(own.impl_->k, k);
        }
        ~Exchange()
        {
            if (!done)
                swap();
        }
    };
    ThinShellOptions next = options();
    next.stretching = stretching;
    next.bending = bending;
    next.variation = variation;
    Exchange exchange{*this, std::make_shared<const ThinShellOptions>(std::move(next)),
                      impl_->coefficients(stretching, bending, variation)};
    exchange.swap();
    const BindReport report = hold(regions().handles(), progress, free_parts());
    exchange.done = true;
    return report;
}

void ThinShell::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<ThinShell&>(other).impl_->bound);
}

LinearResponse ThinShell::respond(const MatrixX& constraints) const
{
    const AccessLock shared = reading();
    return impl_->bound.system.respond(constraints);
}

SolveReport ThinShell::deform(const SolveRequest& request, const Targets& targets, Points& positions) const
{
    const Binding& bound = impl_->bound;
    if (bound.basis && !request.incoming)
        return bound.basis->solve(request.poses, positions, !idle_parts_ride());

    SolvedSystem* const solved = SolvedSystem::of_thread();
    const SolveReport report =
        bound.system.solve(targets, positions, {}, {.start = request.start, .progress = request.progress});
    if (solved)
        impl_->describe(regions(), options().laplacian, *solved);
    return report;
}

const AffineBasis* ThinShell::affine_basis() const { return impl_->bound.basis.get(); }

} // namespace sinew
