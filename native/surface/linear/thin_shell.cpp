// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/linear/thin_shell.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/operators/painted.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/sparse_columns.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

namespace sinew {

namespace {

constexpr int most_basis_handles = 16; ///< 64 columns: 0.5 KB a vertex
constexpr double least_painted = 1e-6; ///< of the largest painted value

double mean_over(const std::vector<double>& values, std::span<const int> vertices)
{
    double sum = 0.0;
    for (int v : vertices)
        sum += values[v];
    return sum / static_cast<double>(vertices.size());
}

/// The C of the header, and the factor of an element in L_kv.
double bending_continuity(const Regions& regions, int vertex)
{
    const int handle = regions.hard(vertex);
    return handle < 0 ? 1.0 : std::min(regions.continuity(handle), 1.0);
}

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

/// Values a vertex of the three stiffnesses; an empty one's term is absent.
struct Coefficients
{
    std::vector<double> stretching, bending, variation;
};

/// What a frame needs. Rows of x that are neither given nor solved for stay zero, as those of the pull where
/// nothing pulls.
struct Frame
{
    RowMatrix x, pull;
    ConstrainedQuadratic::Workspace solve;
};

/// What a bind makes. Replaced as a whole, so a bind that fails changes nothing.
struct Binding
{
    std::vector<Handle> handles;
    Coefficients k;
    Regions regions;
    std::vector<Constraint> constraints;
    std::vector<double> soft_stiffness;
    ConstrainedQuadratic system; ///< of A, soft terms on its diagonal
    std::unique_ptr<AffineBasis> basis;
    std::unique_ptr<Pool<Frame>> frames = std::make_unique<Pool<Frame>>();

    bool is_soft(std::size_t row) const { return row >= constraints.size() - soft_stiffness.size(); }
    double stiffness(std::size_t row) const
    {
        return soft_stiffness[row + soft_stiffness.size() - constraints.size()];
    }
    /// See ThinShell::respond(); n vertices.
    LinearResponse respond(int n, const MatrixX& values) const;
};

LinearResponse Binding::respond(int n, const MatrixX& values) const
{
    const auto columns = values.cols();
    LinearResponse response;
    RowMatrix& x = response.displacement;
    x = RowMatrix::Zero(n, columns);
    std::optional<RowMatrix> pull; // b: the soft constraints' side
    if (!soft_stiffness.empty())
        pull = RowMatrix::Zero(n, columns);
    MatrixX soft_energy = MatrixX::Zero(columns, columns);
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int vertex = constraints[row].vertex;
        const auto target = values.row(row);
        if (is_soft(row)) {
            pull->row(vertex) += stiffness(row) * target;
            soft_energy += stiffness(row) * target.transpose() * target;
        } else {
            x.row(vertex) = target;
        }
    }

    system.solve(x, pull ? &*pull : nullptr);
    ConstrainedQuadratic::Forms forms = system.forms(x, pull ? &*pull : nullptr);
    // A holds the soft stiffness on its diagonal, so that
    // x^T A x - x^T b - b^T x + sum s c c^T is the elastic plus the soft energy, doubled.
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
    SurfaceMesh rest;
    ThinShellOptions options;
    Components parts;
    Binding bound;
    int factorizations = 0;

    Impl(const SurfaceMesh& mesh, const ThinShellOptions& given)
        : rest(mesh), options(given), parts(connected_components(rest))
    {
        bound.k = coefficients(given.stretching, given.bending, given.variation);
        bound.regions = Regions({}, parts);
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

    /// The floor under triangle areas that the highest order present needs.
    static double least_area(const Coefficients& k)
    {
        return least_area_for_order(!k.variation.empty() ? 3 : !k.bending.empty() ? 2 : 1);
    }

    /// A of the header, without soft terms.
    /// Eigen's matrices are copied where others move: they change hands by swap.
    std::shared_ptr<SparseMatrix> assemble(const Regions& regions, const Coefficients& k,
                                           const TriangleMetric& metric) const
    {
        const int n = rest.vertex_count();
        const auto laplacian = [&](const ElementScale& scale) {
            return laplacian_matrix(rest, options.laplacian, metric, scale);
        };
        auto sum = std::make_shared<SparseMatrix>(n, n);
        SparseMatrix& A = *sum;
        const auto add = [&A](SparseMatrix&& term) {
            if (A.nonZeros() == 0)
                A.swap(term);
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

    static void add_soft_terms(Binding& next, SparseMatrix& A)
    {
        if (next.regions.soft().empty())
            return;
        const VectorX diagonal = A.diagonal();
        const double mean = diagonal.mean() > 0 ? diagonal.mean() : 1.0;
        for (const SoftConstraint& s : next.regions.soft()) {
            const double unit = diagonal[s.vertex] > 0 ? diagonal[s.vertex] : mean; // loose vertices
            next.soft_stiffness.push_back(s.stiffness() * unit);
        }
        for (std::size_t k = 0; k < next.soft_stiffness.size(); ++k) {
            const int v = next.regions.soft()[k].vertex;
            A.coeffRef(v, v) += next.soft_stiffness[k];
        }
        A.makeCompressed();
    }

    /// Binds `next`, whose handles and coefficients are set. The factor moves over, so that its
    /// symbolic part serves again where the pattern is the same; it moves back where anything throws.
    BindReport bind(Binding next, const Progress& progress)
    {
        const auto start = std::chrono::steady_clock::now();
        progress.tick(0.0, "assembling the energy");
        next.regions = Regions(next.handles, parts);
        next.constraints = next.regions.constraints();
        int degenerate = 0;
        std::shared_ptr<SparseMatrix> A;
        {
            const TriangleMetric metric = triangle_metric(rest, least_area(next.k));
            degenerate = degenerate_face_count(rest, metric);
            A = assemble(next.regions, next.k, metric);
        }
        add_soft_terms(next, *A);

        progress.tick(0.2, "factorising");
        next.system = std::move(bound.system);
        const ConstrainedQuadratic::Problem before = next.system.problem();
        try {
            factorize(next, std::move(A));
            progress.tick(0.7, "computing the basis");
            if (options.affine_basis && next.regions.handle_count() <= most_basis_handles)
                next.basis =
                    std::make_unique<AffineBasis>(rest.points(), next.regions, [&](const MatrixX& values) {
                        return next.respond(rest.vertex_count(), values);
                    });
            progress.tick(1.0, "bound");
        } catch (const std::exception&) {
            next.system.restore(before);
            bound.system = std::move(next.system);
            throw;
        }
        bound = std::move(next);

        BindReport report = bound.regions.report();
        report.degenerate_faces = degenerate;
        report.factorizations = factorizations;
        report.analyses = bound.system.factor().analyses();
        report.refactored = bound.system.factor().share();
        report.factor_bytes = bound.system.factor().bytes();
        report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return report;
    }

    void factorize(Binding& next, std::shared_ptr<const SparseMatrix> A)
    {
        std::vector<bool> free(rest.vertex_count());
        for (int v = 0; v < rest.vertex_count(); ++v)
            free[v] = next.regions.is_free(v);
        next.system.factorize(std::move(A), free);
        ++factorizations;
    }
};

ThinShell::ThinShell(const SurfaceMesh& rest, const ThinShellOptions& options)
    : impl_(std::make_unique<Impl>(rest, options))
{
}

ThinShell::~ThinShell() = default;
ThinShell::ThinShell(ThinShell&&) noexcept = default;

BindReport ThinShell::set_handles(const std::vector<Handle>& handles, const Progress& progress)
{
    Binding next;
    next.handles = handles;
    next.k = impl_->bound.k;
    return impl_->bind(std::move(next), progress);
}

BindReport ThinShell::set_stiffness(const Stiffness& stretching, const Stiffness& bending,
                                    const Stiffness& variation, const Progress& progress)
{
    Binding next;
    next.handles = impl_->bound.handles;
    next.k = impl_->coefficients(stretching, bending, variation);
    return impl_->bind(std::move(next), progress);
}

LinearResponse ThinShell::respond(const MatrixX& constraints) const
{
    return impl_->bound.respond(rest().vertex_count(), constraints);
}

SolveReport ThinShell::solve(const Poses& poses, Points& positions, const std::optional<PointsView>& incoming,
                             const std::vector<bool>* from_rest) const
{
    const Binding& bound = impl_->bound;
    const Targets targets{poses, view(rest().points()), incoming, from_rest};
    targets.check(bound.regions.handle_count());
    if (!bound.system.problem().matrix) { // no set_handles yet: nothing is held
        positions = targets.base();
        return SolveReport{.converged = true};
    }
    if (bound.basis && !incoming)
        return bound.basis->solve(poses, positions);

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
        return targets.of(vertex, handle) - base.row(vertex).transpose();
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

const SurfaceMesh& ThinShell::rest() const { return impl_->rest; }
const Regions& ThinShell::regions() const { return impl_->bound.regions; }
const AffineBasis* ThinShell::affine_basis() const { return impl_->bound.basis.get(); }

} // namespace sinew
