// SPDX-License-Identifier: GPL-3.0-or-later
// The peers of the benchmarks as a Python module: CHOLMOD, the loops of papers, and OpenSubdiv's evaluator.
#include <cholmod.h>
#ifdef SINEW_HAVE_OPENMP
#include <omp.h>
#endif
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace py = pybind11;

namespace {

using Ints = py::array_t<int, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Columns = py::array_t<double, py::array::f_style | py::array::forcecast>;

/// CHOLMOD's own OpenMP loops and its BLAS use one thread, which is the fastest setting here.
struct Tamed
{
    Tamed()
    {
#ifdef SINEW_HAVE_OPENMP
        levels = omp_get_max_active_levels();
        omp_set_max_active_levels(0);
#endif
        if (openblas_set_num_threads)
            openblas_set_num_threads(1);
    }
    ~Tamed()
    {
#ifdef SINEW_HAVE_OPENMP
        omp_set_max_active_levels(levels);
#endif
    }
    int levels = 1;
};

/// Supernodal factor of a symmetric matrix whose lower triangle is given by columns.
class Cholmod
{
public:
    Cholmod(Ints offsets, Ints rows, Doubles values)
        : offsets_(std::move(offsets)), rows_(std::move(rows)), values_(std::move(values))
    {
        cholmod_start(&common_);
        common_.supernodal = CHOLMOD_SUPERNODAL;
        common_.nmethods = 1;
        common_.method[0].ordering = CHOLMOD_AMD;
        common_.postorder = true;
        matrix_.nrow = matrix_.ncol = offsets_.size() - 1;
        matrix_.nzmax = rows_.size();
        matrix_.p = const_cast<int*>(offsets_.data());
        matrix_.i = const_cast<int*>(rows_.data());
        matrix_.x = const_cast<double*>(values_.data());
        matrix_.stype = -1;
        matrix_.itype = CHOLMOD_INT;
        matrix_.xtype = CHOLMOD_REAL;
        matrix_.dtype = CHOLMOD_DOUBLE;
        matrix_.sorted = matrix_.packed = true;
    }
    ~Cholmod()
    {
        const Tamed tamed;
        cholmod_free_dense(&x_, &common_);
        cholmod_free_dense(&y_, &common_);
        cholmod_free_dense(&e_, &common_);
        cholmod_free_factor(&factor_, &common_);
        cholmod_finish(&common_);
    }
    Cholmod(const Cholmod&) = delete;
    Cholmod& operator=(const Cholmod&) = delete;

    /// Computes the ordering, the symbolic and the numeric factor.
    void factorize()
    {
        const Tamed tamed;
        cholmod_free_factor(&factor_, &common_);
        factor_ = cholmod_analyze(&matrix_, &common_);
        if (!factor_ || !cholmod_factorize(&matrix_, factor_, &common_) || common_.status != CHOLMOD_OK)
            throw std::runtime_error("CHOLMOD failed with status " + std::to_string(common_.status));
    }

    /// The solution and CHOLMOD's workspace are kept for the next call.
    void solve(const Columns& rhs)
    {
        if (rhs.ndim() != 2 || static_cast<std::size_t>(rhs.shape(0)) != matrix_.nrow)
            throw std::invalid_argument("the right side must be (n, k)");
        const Tamed tamed;
        cholmod_dense b{};
        b.nrow = b.d = rhs.shape(0);
        b.ncol = rhs.shape(1);
        b.nzmax = rhs.size();
        b.x = const_cast<double*>(rhs.data());
        b.xtype = CHOLMOD_REAL;
        b.dtype = CHOLMOD_DOUBLE;
        if (!cholmod_solve2(CHOLMOD_A, factor_, &b, nullptr, &x_, nullptr, &y_, &e_, &common_))
            throw std::runtime_error("CHOLMOD's solve failed");
    }

    Columns solution() const
    {
        Columns out({x_->nrow, x_->ncol});
        std::copy_n(static_cast<const double*>(x_->x), x_->nrow * x_->ncol, out.mutable_data());
        return out;
    }

    /// Of the factor.
    std::int64_t bytes() const
    {
        return static_cast<std::int64_t>(factor_->xsize * sizeof(double) +
                                         (factor_->ssize + 3 * factor_->nsuper + 2 * factor_->n) *
                                             sizeof(int));
    }

private:
    Ints offsets_, rows_;
    Doubles values_;
    cholmod_sparse matrix_{};
    cholmod_common common_{};
    cholmod_factor* factor_ = nullptr;
    cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
};

} // namespace

void bind_papers(py::module_& m);
void bind_subdivision(py::module_& m);

PYBIND11_MODULE(sinew_peers, m)
{
    using namespace py::literals;
    m.attr("__doc__") = "What the benchmarks of Sinew compare with.";
    py::class_<Cholmod>(m, "Cholmod")
        .def(py::init<Ints, Ints, Doubles>(), "offsets"_a, "rows"_a, "values"_a)
        .def("factorize", &Cholmod::factorize)
        .def("solve", &Cholmod::solve, "rhs"_a)
        .def_property_readonly("solution", &Cholmod::solution)
        .def_property_readonly("bytes", &Cholmod::bytes);
    bind_papers(m);
    bind_subdivision(m);
}
