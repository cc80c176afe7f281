// SPDX-License-Identifier: GPL-3.0-or-later
// The peers of the benchmarks as a Python module: CHOLMOD, the loops of papers, and OpenSubdiv's evaluator.
#include <Eigen/CholmodSupport>
#ifdef SINEW_HAVE_OPENMP
#include <omp.h>
#endif
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <stdexcept>

namespace py = pybind11;

namespace {

using Sparse = Eigen::SparseMatrix<double>;

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

/// Supernodal factor of a symmetric matrix whose lower triangle is given.
class Cholmod : Eigen::CholmodSupernodalLLT<Sparse>
{
public:
    explicit Cholmod(Sparse lower) : lower_(std::move(lower))
    {
        cholmod().nmethods = 1;
        cholmod().method[0].ordering = CHOLMOD_AMD;
        cholmod().postorder = true;
    }
    ~Cholmod()
    {
        for (cholmod_dense** own : {&x_, &y_, &e_})
            cholmod_free_dense(own, &cholmod());
    }

    /// Computes the ordering, the symbolic and the numeric factor.
    void factorize()
    {
        const Tamed tamed;
        if (compute(lower_).info() != Eigen::Success)
            throw std::runtime_error("CHOLMOD failed");
    }

    /// The solution and CHOLMOD's workspace are kept for the next call.
    void solve(const Eigen::Ref<const Eigen::MatrixXd>& rhs)
    {
        if (rhs.rows() != lower_.rows())
            throw std::invalid_argument("the right side must be (n, k)");
        const Tamed tamed;
        cholmod_dense b = Eigen::viewAsCholmod(rhs.const_cast_derived());
        if (!cholmod_solve2(CHOLMOD_A, m_cholmodFactor, &b, nullptr, &x_, nullptr, &y_, &e_, &cholmod()))
            throw std::runtime_error("CHOLMOD's solve failed");
    }

    Eigen::MatrixXd solution() const
    {
        return Eigen::MatrixXd::Map(static_cast<const double*>(x_->x), x_->nrow, x_->ncol);
    }

    /// Of the factor.
    std::int64_t bytes() const
    {
        const cholmod_factor& f = *m_cholmodFactor;
        return static_cast<std::int64_t>(f.xsize * sizeof(double) +
                                         (f.ssize + 3 * f.nsuper + 2 * f.n) * sizeof(int));
    }

private:
    Sparse lower_;
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
        .def(py::init<Sparse>(), "lower"_a)
        .def("factorize", &Cholmod::factorize)
        .def("solve", &Cholmod::solve, "rhs"_a)
        .def_property_readonly("solution", &Cholmod::solution)
        .def_property_readonly("bytes", &Cholmod::bytes);
    bind_papers(m);
    bind_subdivision(m);
}
