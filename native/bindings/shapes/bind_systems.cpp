// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/options.h"
#include "native/methods/surface/system.h"
#include "native/solvers/systems/linear_solver.h"

#include <pybind11/eigen.h>

#include <numeric>
#include <utility>

namespace sinew::bindings {

namespace {

using SystemOrMatrix = Typed<"LinearSystem | scipy.sparse.csc_matrix">;
using OptionalMatrix = Typed<"scipy.sparse.csc_matrix | None">;
using Solution = Typed<"tuple[numpy.typing.NDArray[numpy.float64], SolutionReport]">;

/// With sorted columns and without double entries. Those of SciPy may be neither.
SparseMatrix tidy(const py::object& matrix)
{
    const std::string kind =
        py::str(py::getattr(py::getattr(matrix, "dtype", py::none()), "kind", py::none()));
    if (!py::hasattr(matrix, "tocsc") || kind == "c")
        throw py::type_error("a matrix is a SciPy sparse matrix of real numbers");
    return SparseMatrix(matrix.cast<SparseMatrix>().transpose()).transpose();
}

/// (n,) or (n, k) numbers.
RowMatrix columns_of(const FloatArray& array, const char* name)
{
    if (array.ndim() != 1 && array.ndim() != 2)
        throw InvalidOption(std::string(name) + ": the shape must be (n,) or (n, k)");
    return Eigen::Map<const RowMatrix>(array.data(), array.shape(0), array.ndim() == 2 ? array.shape(1) : 1);
}

LinearSystem of_matrix(const py::object& matrix)
{
    LinearSystem system;
    system.matrix = tidy(matrix);
    system.vertices.resize(system.matrix.cols());
    std::iota(system.vertices.begin(), system.vertices.end(), 0);
    return system;
}

LinearSystem make_system(const SystemOrMatrix& matrix, const OptionalArray& right_side,
                         const OptionalArray& points, const OptionalMatrix& graph, const OptionalArray& mass,
                         const OptionalArray& vertices, int order, double membrane, const OptionalArray& held)
{
    LinearSystem system = of_matrix(matrix);
    system.order = order;
    system.membrane = membrane;
    if (!right_side.is_none())
        system.right_side = columns_of(floats(right_side, "right_side"), "right_side");
    if (const OptionalPoints given(points, "points"); given.view)
        system.points = *given.view;
    if (!graph.is_none())
        system.graph = tidy(graph);
    if (!mass.is_none()) {
        const std::vector<double> values = numbers(mass, "mass");
        system.mass = Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size()));
    }
    if (!vertices.is_none())
        system.vertices = integers(vertices, "vertices");
    if (!held.is_none())
        system.held = columns_of(floats(held, "held"), "held");
    require_consistent(system);
    return system;
}

Solution solve_system(const SystemOrMatrix& given, const OptionalArray& b, const Chosen<Solver>& solver,
                      const Chosen<Ordering>& ordering, const Chosen<Precondition>& preconditioner,
                      const Chosen<Cycle>& cycle, double tolerance, int max_iterations, bool error_bound,
                      const Callback& callback)
{
    const SolverOptions options{.solver = solver.value("solver"),
                                .ordering = ordering.value("ordering"),
                                .preconditioner = preconditioner.value("preconditioner"),
                                .cycle = cycle.value("cycle"),
                                .tolerance = tolerance,
                                .max_iterations = max_iterations,
                                .error_bound = error_bound};
    const bool is_system = py::isinstance<LinearSystem>(given);
    const LinearSystem own = is_system ? LinearSystem() : of_matrix(given);
    const LinearSystem& system = is_system ? given.cast<const LinearSystem&>() : own;
    if (b.is_none() && system.right_side.size() == 0)
        throw InvalidOption("b: give one, as the system has no right side");
    const FloatArray array = b.is_none() ? FloatArray() : floats(b, "b");
    const RowMatrix B = b.is_none() ? system.right_side : columns_of(array, "b");
    const Progress ticks = progress(callback);
    RowMatrix x;
    SolutionReport report;
    {
        const py::gil_scoped_release unlocked;
        x = solve_linear(system, B, options, report, ticks);
    }
    const bool flat = !b.is_none() && array.ndim() == 1;
    return py::make_tuple(flat ? py::object(py::cast(VectorX(x.col(0)))) : py::object(py::cast(x)), report);
}

} // namespace

void bind_systems(py::module_& module)
{
    py::class_<LinearSystem>(module, "LinearSystem", R"(The equations A x = b of a method, for solve().

Each of the m unknowns belongs to one of n nodes, in most cases the vertices of a mesh; the others are held, and their
value is 0. All that is read from it are copies.)")
        .def(py::init(&make_system), py::arg("matrix"), py::arg("right_side") = py::none(), py::kw_only(),
             py::arg("points") = py::none(), py::arg("graph") = py::none(), py::arg("mass") = py::none(),
             py::arg("vertices") = py::none(), py::arg("order") = 1, py::arg("membrane") = 0.0,
             py::arg("held") = py::none(), R"(
matrix      (m, m) SciPy sparse A, with both triangles.
right_side  None, or (m,) or (m, k) b.
points      None, or (n, 3) the nodes. Multigrid needs them and the graph.
graph       None, or (n, n) SciPy sparse L, symmetric and positive semi-definite as in laplacian().
mass        None (1), or (n,) M, > 0; infinite where a node does not count.
vertices    None for all, or (m,) the node of each unknown, rising.
order       1: A is the block of the unknowns in L. 2: that in L M^-1 L + membrane L. 3 and more: something else.
membrane    >= 0, of order 2.
held        None, or (n,) or (n, k) the values of held nodes that the right side comes from, 0 at the unknowns.

Raises InvalidOption where sizes do not match or a number is not finite.)")
        .def_property_readonly(
            "matrix", [](const LinearSystem& s) { return s.matrix; }, "(m, m) A, SciPy sparse.")
        .def_property_readonly(
            "right_side", [](const LinearSystem& s) { return s.right_side; }, "(m, k) b, or empty.")
        .def_property_readonly(
            "points", [](const LinearSystem& s) { return s.points; }, "(n, 3) the nodes, or empty.")
        .def_property_readonly(
            "graph", [](const LinearSystem& s) { return s.graph; }, "(n, n) L, SciPy sparse, or empty.")
        .def_property_readonly(
            "mass", [](const LinearSystem& s) { return s.mass; }, "(n,) M, or empty.")
        .def_property_readonly(
            "held", [](const LinearSystem& s) { return s.held; }, "(n, k) values of held nodes, or empty.")
        .def_property_readonly(
            "vertices", [](const LinearSystem& s) { return to_numpy(s.vertices); },
            "(m,) the node of each unknown.")
        .def_readonly("order", &LinearSystem::order,
                      "1 or 2, the power of L in A; 3 and more: something else.")
        .def_readonly("membrane", &LinearSystem::membrane, "How much of L is in A beside L M^-1 L.")
        .def("__repr__", [](const LinearSystem& s) {
            return "<LinearSystem: " + std::to_string(s.matrix.cols()) + " unknowns, " +
                   std::to_string(s.matrix.nonZeros()) + " entries>";
        });

    py::class_<SolutionReport>(module, "SolutionReport",
                               "What a solution of solve() cost, and how good it is.")
        .def_property_readonly(
            "solver", [](const SolutionReport& r) { return name_of(r.solver); },
            "The solver that was chosen.")
        .def_readonly("why", &SolutionReport::why, "Why it was chosen, and what had to be changed.")
        .def_readonly("setup", &SolutionReport::setup, "Seconds of checks, and of the order of elimination.")
        .def_readonly("precompute", &SolutionReport::precompute,
                      "Seconds of the factor, the preconditioner or the hierarchy.")
        .def_readonly("solve", &SolutionReport::solve, "Seconds of the solution of all columns.")
        .def_readonly("iterations", &SolutionReport::iterations, "Iterations; 0 of direct solvers.")
        .def_readonly("residual", &SolutionReport::residual, "|b - A x| / |b| of the worst column.")
        .def_readonly("error_bound", &SolutionReport::error_bound,
                      "norm(A^-1) |b - A x| of the worst column, a bound of |x - A^-1 b|, with the norm "
                      "estimated by 16 steps\n"
                      "of Lanczos' method; -1 unless it was asked for.")
        .def_readonly("bytes", &SolutionReport::bytes, "Memory of what was precomputed.")
        .def_readonly("fill", &SolutionReport::fill,
                      "Entries of the factor for each of the lower triangle of A; 0 without a factor.")
        .def_readonly("envelope", &SolutionReport::envelope,
                      "Entries from the first of each row to the diagonal, in the order of elimination.")
        .def_readonly("levels", &SolutionReport::levels, "Levels of the hierarchy; 0 without one.")
        .def("__repr__", [](const SolutionReport& r) {
            return std::string("<SolutionReport: ") + name_of(r.solver) + ", " +
                   std::to_string(r.iterations) + " iterations>";
        });

    module.def(
        "system",
        [](const SurfaceMethod& method, const ArrayLike& poses) {
            const Poses maps = bindings::poses(poses);
            const py::gil_scoped_release unlocked;
            return system_of(method, maps);
        },
        py::arg("method"), py::arg("poses"),
        R"(The linear system that a method solves for these poses -> LinearSystem.

method  SurfaceMethod with handles.
poses   (k, 3, 4), as in solve() of the method.

Where the method solves several, it is the last one. The unknowns are displacements of free vertices. Raises
InvalidConstraint before set_handles(), InvalidOption of a method that solves no linear system with its poses.
Cost: a solve, and a copy.)");
    module.def("solve", &solve_system, py::arg("system"), py::arg("b") = py::none(), py::kw_only(),
               py::arg("solver") = "automatic", py::arg("ordering") = "automatic",
               py::arg("preconditioner") = "jacobi", py::arg("cycle") = "full", py::arg("tolerance") = 1e-8,
               py::arg("max_iterations") = 10000, py::arg("error_bound") = false,
               py::arg("progress") = py::none(),
               R"(Solve A x = b by any solver of the tutorial's appendix A -> (x, SolutionReport).

system          LinearSystem, or a square SciPy sparse matrix.
b               (m,) or (m, k); None for the right side of the system.
solver          'cholesky' (supernodal), 'simplicial', 'lu' (sparse, needs no symmetry), 'conjugate_gradients',
                'multigrid' (conjugate gradients with a cycle; needs points and graph), 'dense_cholesky', 'dense_lu',
                'dense_qr', 'dense_svd' (at most 5000 unknowns), or 'automatic': 'cholesky', where the matrix is not
                symmetric 'lu', and where the factor needs more than limit_memory() allows 'multigrid'.
ordering        of 'cholesky' and 'simplicial', as in SpdFactor.
preconditioner  of 'conjugate_gradients': 'none', 'jacobi', 'incomplete_cholesky', which is refused where it breaks
                down, or 'shifted_incomplete_cholesky', which raises the diagonal there and says so.
cycle           of 'multigrid': 'v', 'full', which begins with nested iteration from the values of held nodes, or 'cascading', which has no cycle.
tolerance       of iterations: |b - A x| / |b|; with the cycles 'v' and 'full' the largest entry of an estimated
                error, as a share of that of x.
max_iterations  at most so many for each four columns, and 500 cycles.
error_bound     whether to estimate norm(A^-1) |b - A x| of a symmetric A, by 16 solutions more.
progress        None or callable(fraction, stage); returning False cancels.

Raises InvalidOption where sizes do not match, a number is not finite, an option is unknown or does not fit the matrix;
FactorizationFailed where A is singular, or not positive definite as the solver needs; NotConverged where iterations are
used up or diverge; OutOfMemory, Cancelled.)");
}

} // namespace sinew::bindings
