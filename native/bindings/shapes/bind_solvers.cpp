// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/options.h"
#include "native/core/read_write_lock.h"
#include "native/mesh/half_edges.h"
#include "native/solvers/spd_factor.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

/// A factor that threads may share.
struct SharedFactor
{
    SpdFactor factor;
    mutable ReadWriteLock access{};

    AccessLock reading() const { return {AccessLock::reading, access}; }
};

template <auto member>
auto read_of(const SharedFactor& shared)
{
    const py::gil_scoped_release unlocked;
    const AccessLock lock = shared.reading();
    return (shared.factor.*member)();
}

/// A matrix with sorted columns and without double entries, as the factor needs it. Those of SciPy may be
/// neither.
SparseMatrix tidy(const SparseMatrix& matrix)
{
    if (matrix.rows() != matrix.cols())
        throw InvalidOption("matrix: not square");
    SparseMatrix sorted = SparseMatrix(matrix.transpose()).transpose();
    for (int c = 0; c < sorted.cols(); ++c)
        for (SparseMatrix::InnerIterator it(sorted, c); it; ++it)
            if (!std::isfinite(it.value()))
                throw InvalidOption("matrix: NaN or infinite entry in column " + std::to_string(c));
    return sorted;
}

/// A matrix with these entries, their mirror images and a diagonal.
SparseMatrix pattern_of(const std::vector<Edge>& entries, int size)
{
    require_at_least(size, 0, "size");
    std::vector<Eigen::Triplet<double>> triplets;
    for (const auto& [row, column] : entries) {
        if (std::min(row, column) < 0 || std::max(row, column) >= size)
            throw InvalidOption("entries: (" + std::to_string(row) + ", " + std::to_string(column) +
                                ") is not in a matrix of " + std::to_string(size) + " rows");
        triplets.emplace_back(row, column, 1.0);
        triplets.emplace_back(column, row, 1.0);
    }
    for (int k = 0; k < size; ++k)
        triplets.emplace_back(k, k, 1.0);
    SparseMatrix pattern(size, size);
    pattern.setFromTriplets(triplets.begin(), triplets.end());
    return pattern;
}

} // namespace

void bind_solvers(py::module_& module)
{
    py::class_<SharedFactor>(module, "SpdFactor",
                             "A sparse Cholesky factor for many right-hand sides. Threads may share it: "
                             "factorize() waits until\n"
                             "other calls have ended, and they wait for it.")
        .def(py::init([](const SparseMatrix& matrix, const Chosen<Ordering>& ordering,
                         const Chosen<FactorBackend>& backend) {
                 SharedFactor shared{SpdFactor(
                     {.backend = backend.value("backend"), .ordering = ordering.value("ordering")})};
                 const SparseMatrix sorted = tidy(matrix);
                 const py::gil_scoped_release unlocked;
                 shared.factor.factorize(sorted);
                 return shared;
             }),
             py::arg("matrix"), py::arg("ordering") = "automatic", py::arg("backend") = "automatic", R"(
matrix    (n, n) SciPy sparse, symmetric positive definite.
ordering  'natural', 'cuthill_mckee', 'reverse_cuthill_mckee', 'minimum_degree', 'nested_dissection' by METIS,
          'patch_dissection' by Sinew, or 'automatic': of these, 'minimum_degree' below 50,000 rows and
          'patch_dissection' from there on.
backend   'automatic', 'supernodal', 'simplicial' (CHOLMOD) or 'ldlt' (Eigen).

Raises FactorizationFailed where the matrix is singular or indefinite, OutOfMemory above limit_memory().)")
        .def(
            "solve",
            [](const SharedFactor& shared, const ArrayLike& rhs) {
                const FloatArray array = floats(rhs, "rhs");
                if (array.ndim() != 1 && array.ndim() != 2)
                    throw InvalidConstraint("rhs: the shape must be (n,) or (n, k)");
                using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
                const py::ssize_t columns = array.ndim() == 2 ? array.shape(1) : 1;
                const MatrixX b = Eigen::Map<const RowMajor>(array.data(), array.shape(0), columns);
                MatrixX x;
                {
                    const py::gil_scoped_release unlocked;
                    const AccessLock lock = shared.reading();
                    x = shared.factor.solve(b);
                }
                return array.ndim() == 1 ? py::object(py::cast(VectorX(x.col(0)))) : py::object(py::cast(x));
            },
            py::arg("rhs"),
            "(n,) or (n, k) -> the solution in the same shape. Two triangular solves per column.\n"
            "Raises InvalidConstraint for another shape.")
        .def(
            "factorize",
            [](SharedFactor& shared, const SparseMatrix& matrix) {
                const SparseMatrix sorted = tidy(matrix);
                const py::gil_scoped_release unlocked;
                const AccessLock lock(AccessLock::changing, shared.access);
                shared.factor.factorize(sorted);
            },
            py::arg("matrix"),
            "(n, n) a matrix with other values; the symbolic part is kept if the pattern is the same.\n"
            "Raises FactorizationFailed where the matrix is singular or indefinite, OutOfMemory.")
        .def_property_readonly("size", &read_of<&SpdFactor::size>, "Rows of the matrix, n.")
        .def_property_readonly("nonzeros", &read_of<&SpdFactor::nonzeros>, "Entries of the factor.")
        .def_property_readonly("bytes", &read_of<&SpdFactor::bytes>, "Memory of the factor.")
        .def_property_readonly("factorizations", &read_of<&SpdFactor::factorizations>,
                               "Numeric factorisations so far.")
        .def_property_readonly("analyses", &read_of<&SpdFactor::analyses>, "Symbolic factorisations so far.")
        .def("__repr__", [](const SharedFactor& shared) {
            return "<SpdFactor: " + std::to_string(read_of<&SpdFactor::size>(shared)) + " rows, " +
                   std::to_string(read_of<&SpdFactor::nonzeros>(shared)) + " entries>";
        });
    module.def(
        "elimination_order",
        [](const ArrayLike& entries, int size, const Chosen<Ordering>& ordering) {
            const Ordering chosen = ordering.value("ordering");
            const std::vector<Edge> given = index_pairs(entries, "entries");
            if (size < 1)
                throw InvalidOption("size must be at least 1");
            std::vector<int> order;
            {
                const py::gil_scoped_release unlocked;
                order = elimination_order(pattern_of(given, size), chosen);
            }
            return to_numpy(order);
        },
        py::arg("entries"), py::arg("size"), py::arg("ordering") = "automatic", R"(
The order in which a factor of a symmetric matrix eliminates the unknowns -> (n,): row `order[i]` is number i.

entries   (k, 2) rows and columns of its entries, such as the edges of a mesh; of one of both triangles at least.
size      n, its number of rows, at least 1.
ordering  as in SpdFactor.

Raises InvalidOption for another word, or an entry that is not in the matrix.)");
}

} // namespace sinew::bindings
