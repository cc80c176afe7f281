// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/thin_shell.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/painted.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <cmath>
#include <memory>
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

/// The workspace of a frame. Rows of x that are neither given nor solved for stay zero, and so do rows of
/// `pull` where no handle pulls.
struct Frame
{
    RowMatrix x, pull;
    ConstrainedQuadratic::Workspace solve;
};

/// The results of a bind. They are replaced together, so a bind that fails changes nothing.
struct Binding
{
    std::vector<Constraint> constraints;
    std::vector<double> soft_stiffness;
    ConstrainedQuadratic system; ///< of A with the soft terms on its diagonal
    std::unique_ptr<AffineBasis> basis;
    std::unique_ptr<Pool<Frame>> frames = std::make_unique<Pool<Frame>>();
    int factorizations = 0;

    bool is_soft(std::size_t row) const { return row >= constraints.size() - soft_stiffness.size(); }
    double stiffness(std::size_t row) const
    {
        return soft_stiffness[row + soft_stiffness.size() - constraints.size()];
    }
    LinearResponse respond(int n, const MatrixX& constraint_values) const;
};

LinearResponse Binding::respond(int n, const MatrixX& constraint_values) const
{
    const auto columns = constraint_values.cols();
    LinearResponse response;
    RowMatrix& x = response.displacement;
    x = RowMatrix::Zero(n, columns);
    std::optional<RowMatrix> pull; // b, which comes from the soft constraints
    if (!soft_stiffness.empty())
        pull = RowMatrix::Zero(n, columns);
    MatrixX soft_energy = MatrixX::Zero(columns, columns);
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int vertex = constraints[row].vertex;
        const auto target = constraint_values.row(row);
        if (is_soft(row)) {
            pull->row(vertex) += stiffness(row) * target;
            soft_energy += stiffness(row) * target.transpose() * target;
        } else {
            x.row(vertex) = target;
        }
    }

    system.solve(x, pull ? &*pull : nullptr);
    ConstrainedQuadratic::Forms forms = system.forms(x, pull ? &*pull : nullptr);
    // A includes the soft stiffness on its diagonal. Therefore x^T A x - x^T b - b^T x + sum s c c^T is twice
    // the sum of the elastic and the soft energy.
    response.energy = forms.energy + soft_energy;
    if (pull) {
        const MatrixX cross = x.transpose() * *pull;
        response.energy -= cross + cross.transpose();
    }
    response.residual = std::move(forms.residual);
    response.load = std::move(forms.load);
    return response;
}

} // namespace

struct ThinShell::Impl
{
    const SurfaceMesh& rest;
    ThinShellOptions options;
    Coefficients k;
    Binding bound;

    Impl(const SurfaceMesh& mesh, const ThinShellOptions& given)
        : rest(mesh), options(given), k(coefficients(given.stretching, given.bending, given.variation))
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
    std::shared_ptr<SparseMatrix> assemble(const Regions& regions, const TriangleMetric& metric) const
    {
        const int n = rest.vertex_count();
        const auto laplacian = [&](const ElementScale& scale) {
            return laplacian_matrix(rest, options.laplacian, metric, scale);
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
        VectorX CM = divisible_mass(rest, options.laplacian, metric).cwiseInverse();
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

    static void add_soft_terms(const Regions& regions, Binding& next, SparseMatrix& A)
    {
        if (regions.soft().empty())
            return;
        const VectorX diagonal = A.diagonal();
        const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
        for (const SoftConstraint& s : regions.soft()) {
            const double unit = diagonal[s.vertex] > 0 ? diagonal[s.vertex] : mean; // for loose vertices
            next.soft_stiffness.push_back(s.stiffness() * unit);
        }
        for (std::size_t k = 0; k < next.soft_stiffness.size(); ++k) {
            const int v = regions.soft()[k].vertex;
            A.coeffRef(v, v) += next.soft_stiffness[k];
        }
        A.makeCompressed();
    }

    /// The factor is handed on to the next binding, so that its symbolic part is used again where the pattern
    /// of the matrix is the same.
    void bind(const Regions& regions, BindReport& report, const Progress& progress)
    {
        Binding next;
        next.constraints = regions.constraints();
        std::shared_ptr<SparseMatrix> A;
        {
            const TriangleMetric metric = triangle_metric(rest, least_area());
            report.degenerate_faces = degenerate_face_count(rest, metric);
            A = assemble(regions, metric);
        }
        add_soft_terms(regions, next, *A);
        std::vector<bool> free(rest.vertex_count());
        for (int v = 0; v < rest.vertex_count(); ++v)
            free[v] = regions.is_free(v);

        progress.tick(0.2, "factorising");
        next.system = std::move(bound.system);
        const ConstrainedQuadratic::Problem before = next.system.problem();
        try {
            next.system.factorize(std::move(A), free);
            progress.tick(0.7, "computing the basis");
            if (options.affine_basis && regions.handle_count() <= most_basis_handles) {
                const MatrixX columns = AffineBasis::columns(rest.points(), regions);
                next.basis = std::make_unique<AffineBasis>(
                    rest.points(), next.respond(rest.vertex_count(), columns), regions);
            }
            progress.tick(1.0, "bound");
        } catch (const std::exception&) {
            next.system.restore(before);
            bound.system = std::move(next.system);
            throw;
        }
        next.factorizations = bound.factorizations + 1;
        report.factorizations = next.factorizations;
        report.analyses = next.system.factor().analyses();
        report.refactored = next.system.factor().share();
        report.factor_bytes = next.system.factor().bytes();
        bound = std::move(next);
    }
};

ThinShell::ThinShell(const SurfaceMesh& rest, const ThinShellOptions& options)
    : SurfaceMethod(rest), impl_(std::make_unique<Impl>(this->rest(), options))
{
}

ThinShell::~ThinShell() = default;
ThinShell::ThinShell(ThinShell&&) noexcept = default;

void ThinShell::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    impl_->bind(regions, report, progress);
}

BindReport ThinShell::set_stiffness(const Stiffness& stretching, const Stiffness& bending,
                                    const Stiffness& variation, const Progress& progress)
{
    const AccessLock alone = changing();
    struct Exchange ///< exchanges the stiffnesses, and exchanges them back unless all went well
    {
        Impl& own;
        ThinShellOptions options;
        Coefficients k;
        bool done = false;

        void swap()
        {
            std::swap(own.options, options);
            std::swap(own.k, k);
        }
        ~Exchange()
        {
            if (!done)
                swap();
        }
    } exchange{*impl_, impl_->options, impl_->coefficients(stretching, bending, variation)};
    exchange.options.stretching = stretching;
    exchange.options.bending = bending;
    exchange.options.variation = variation;
    exchange.swap();
    const BindReport report = hold(regions().handles(), progress, free_parts());
    exchange.done = true;
    return report;
}

std::vector<std::string> ThinShell::changed_options(const SurfaceMethod& former) const
{
    const ThinShellOptions &own = impl_->options,
                           &other = static_cast<const ThinShell&>(former).impl_->options;
    return names_of({{"stretching", own.stretching != other.stretching},
                     {"bending", own.bending != other.bending},
                     {"variation", own.variation != other.variation},
                     {"laplacian", own.laplacian != other.laplacian},
                     {"affine_basis", own.affine_basis != other.affine_basis}});
}

bool ThinShell::updates(const std::string& option) const { return option != "laplacian"; }

void ThinShell::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<ThinShell&>(other).impl_->bound);
}

LinearResponse ThinShell::respond(const MatrixX& constraints) const
{
    const AccessLock shared = reading();
    return impl_->bound.respond(rest().vertex_count(), constraints);
}

SolveReport ThinShell::deform(const SolveRequest& request, const Targets& targets, Points& positions) const
{
    const Binding& bound = impl_->bound;
    if (bound.basis && !request.incoming)
        return bound.basis->solve(request.poses, positions, !idle_parts_ride());

    const PointsView base = targets.base();
    const int n = rest().vertex_count();
    const bool soft = !bound.soft_stiffness.empty();
    const auto frame = bound.frames->take([&] {
        auto made = std::make_unique<Frame>();
        made->x = RowMatrix::Zero(n, 3);
        made->pull = RowMatrix::Zero(soft ? n : 0, 3);
        return made;
    });
    RowMatrix& x = frame->x;
    const RowMatrix* const pull = soft ? &frame->pull : nullptr;
    const auto displacement = [&](std::size_t row) -> Vector3 {
        const auto [vertex, handle] = bound.constraints[row];
        return targets.position(vertex, handle) - base.row(vertex).transpose();
    };
    for (std::size_t row = 0; row < bound.constraints.size(); ++row)
        if (bound.is_soft(row))
            frame->pull.row(bound.constraints[row].vertex).setZero();
    for (std::size_t row = 0; row < bound.constraints.size(); ++row) {
        const int vertex = bound.constraints[row].vertex;
        if (bound.is_soft(row))
            frame->pull.row(vertex) += bound.stiffness(row) * displacement(row).transpose();
        else
            x.row(vertex) = displacement(row).transpose();
    }

    bound.system.solve(x, pull, frame->solve);
    const ConstrainedQuadratic::Norms norms = bound.system.norms(x, pull);
    double energy = norms.energy; // as in respond()
    for (std::size_t row = 0; row < bound.constraints.size(); ++row)
        if (bound.is_soft(row)) {
            const Vector3 target = displacement(row),
                          found = x.row(bound.constraints[row].vertex).transpose();
            energy += bound.stiffness(row) * (target - 2 * found).dot(target);
        }
    positions.resize(n, 3);
    parallel_for(n, [&](int i) {
        for (int axis = 0; axis < 3; ++axis)
            positions(i, axis) = base(i, axis) + x(i, axis);
    });

    SolveReport report;
    report.iterations = 1;
    report.converged = true;
    report.energy = 0.5 * energy;
    report.residual = norms.load > 0 ? std::sqrt(norms.residual / norms.load) : 0.0;
    return report;
}

const AffineBasis* ThinShell::affine_basis() const { return impl_->bound.basis.get(); }

} // namespace sinew
