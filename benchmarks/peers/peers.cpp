// SPDX-License-Identifier: GPL-3.0-or-later
// The peers of the benchmarks as a Python module: CHOLMOD, Eigen's LDL^T, and the bandwidth of the memory.
#include "benchmarks/peers/cage_peers.h"
#include "benchmarks/peers/points_peers.h"

#include <cholmod.h>
#ifdef SINEW_HAVE_OPENMP
#include <omp.h>
#endif
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

#include <Eigen/SparseCholesky>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace py = pybind11;

namespace {

using Ints = py::array_t<int, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Singles = py::array_t<float, py::array::c_style>;
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
    Cholmod(Ints offsets, Ints rows, Doubles values, const std::string& ordering)
        : offsets_(std::move(offsets)), rows_(std::move(rows)), values_(std::move(values))
    {
        cholmod_start(&common_);
        common_.supernodal = CHOLMOD_SUPERNODAL;
        common_.nmethods = 1;
        common_.method[0].ordering = ordering == "metis" ? CHOLMOD_METIS : CHOLMOD_AMD;
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

    std::int64_t value_bytes() const { return static_cast<std::int64_t>(factor_->xsize * sizeof(double)); }
    std::int64_t bytes() const
    {
        return value_bytes() + static_cast<std::int64_t>(
                                   (factor_->ssize + 3 * factor_->nsuper + 2 * factor_->n) * sizeof(int));
    }
    /// The largest memory that CHOLMOD had allocated, and its memory now, in bytes.
    std::int64_t peak_bytes() const { return static_cast<std::int64_t>(common_.memory_usage); }
    std::int64_t current_bytes() const { return static_cast<std::int64_t>(common_.memory_inuse); }

private:
    Ints offsets_, rows_;
    Doubles values_;
    cholmod_sparse matrix_{};
    cholmod_common common_{};
    cholmod_factor* factor_ = nullptr;
    cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
};

/// Eigen's simplicial LDL^T with its default ordering.
class EigenLdlt
{
public:
    explicit EigenLdlt(Eigen::SparseMatrix<double> matrix) : matrix_(std::move(matrix)) {}
    void factorize()
    {
        solver_.compute(matrix_);
        if (solver_.info() != Eigen::Success)
            throw std::runtime_error("Eigen's LDL^T failed");
    }
    Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const { return solver_.solve(rhs); }

private:
    Eigen::SparseMatrix<double> matrix_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver_;
};

/// Runs work(begin, end) on `threads` slices of [0, count) in parallel, and returns the seconds.
double timed(std::size_t count, int threads, const std::function<void(std::size_t, std::size_t)>& work)
{
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::thread> others;
    for (int t = 1; t < threads; ++t)
        others.emplace_back(work, count * t / threads, count * (t + 1) / threads);
    work(0, count / threads);
    for (std::thread& other : others)
        other.join();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The bandwidth, in bytes per second, of the fastest of several readings of a block of `bytes`. A small
/// block is read many times, so that the start of the threads does not count.
double read_bandwidth(std::size_t bytes, int threads, int repeats)
{
    const std::size_t count = std::max<std::size_t>(bytes / sizeof(double), 4096);
    const int passes =
        static_cast<int>(std::max<std::size_t>(1, (std::size_t{64} << 20) / (count * sizeof(double))));
    std::vector<double> block(count, 1.0);
    std::vector<double> sums(threads);
    double best = std::numeric_limits<double>::infinity();
    for (int r = 0; r < repeats; ++r)
        best = std::min(best, timed(count, threads, [&](std::size_t begin, std::size_t end) {
                            double lanes[16]{};
                            for (int p = 0; p < passes; ++p) {
                                for (std::size_t i = begin; i + 16 <= end; i += 16)
                                    for (int l = 0; l < 16; ++l)
                                        lanes[l] += block[i + l];
                                asm volatile("" ::: "memory"); // the compiler must not skip a pass
                            }
                            double sum = 0.0;
                            for (double lane : lanes)
                                sum += lane;
                            sums[begin * threads / count] = sum;
                        }));
    if (sums[0] < 0.0)
        throw std::runtime_error("a sum of ones is negative");
    return static_cast<double>(count * sizeof(double)) * passes / best;
}

PeerCage cage(const Doubles& vertices, const Ints& triangles)
{
    return {vertices.data(), triangles.data(), static_cast<int>(vertices.shape(0)),
            static_cast<int>(triangles.shape(0))};
}

} // namespace

void bind_subdivision(py::module_& m);

PYBIND11_MODULE(sinew_peers, m)
{
    using namespace py::literals;
    m.attr("__doc__") = "What the benchmarks of Sinew compare with.";
    m.attr("cholmod_version") = std::to_string(CHOLMOD_MAIN_VERSION) + "." +
                                std::to_string(CHOLMOD_SUB_VERSION) + "." +
                                std::to_string(CHOLMOD_SUBSUB_VERSION);
    m.attr("eigen_version") = std::to_string(EIGEN_WORLD_VERSION) + "." +
                              std::to_string(EIGEN_MAJOR_VERSION) + "." + std::to_string(EIGEN_MINOR_VERSION);
    py::class_<Cholmod>(m, "Cholmod")
        .def(py::init<Ints, Ints, Doubles, std::string>(), "offsets"_a, "rows"_a, "values"_a,
             "ordering"_a = "amd")
        .def("factorize", &Cholmod::factorize)
        .def("solve", &Cholmod::solve, "rhs"_a)
        .def_property_readonly("solution", &Cholmod::solution)
        .def_property_readonly("value_bytes", &Cholmod::value_bytes)
        .def_property_readonly("bytes", &Cholmod::bytes)
        .def_property_readonly("peak_bytes", &Cholmod::peak_bytes)
        .def_property_readonly("current_bytes", &Cholmod::current_bytes);
    py::class_<EigenLdlt>(m, "EigenLdlt")
        .def(py::init<Eigen::SparseMatrix<double>>(), "matrix"_a)
        .def("factorize", &EigenLdlt::factorize)
        .def("solve", &EigenLdlt::solve, "rhs"_a);
    m.def(
        "mean_value",
        [](Doubles vertices, Ints triangles, Doubles points, Doubles weights) {
            peer_mean_value(cage(vertices, triangles), points.data(), static_cast<int>(points.shape(0)),
                            weights.mutable_data());
        },
        "vertices"_a, "triangles"_a, "points"_a, "weights"_a.noconvert());
    m.def(
        "green",
        [](Doubles vertices, Ints triangles, Doubles points, Doubles phi, Doubles psi) {
            peer_green(cage(vertices, triangles), points.data(), static_cast<int>(points.shape(0)),
                       phi.mutable_data(), psi.mutable_data());
        },
        "vertices"_a, "triangles"_a, "points"_a, "phi"_a.noconvert(), "psi"_a.noconvert());
    m.def(
        "rigid_mls",
        [](Doubles handles, Doubles posed, Doubles points, Doubles result) {
            peer_rigid_mls(handles.data(), posed.data(), static_cast<int>(handles.shape(0)), points.data(),
                           static_cast<int>(points.shape(0)), result.mutable_data());
        },
        "handles"_a, "posed"_a, "points"_a, "result"_a.noconvert());
    m.def(
        "sgemm",
        [](Singles weights, Singles factors, Singles result) {
            const Tamed tamed;
            peer_sgemm(weights.data(), static_cast<int>(weights.shape(0)), static_cast<int>(weights.shape(1)),
                       factors.data(), result.mutable_data());
        },
        "weights"_a.noconvert(), "factors"_a.noconvert(), "result"_a.noconvert());
    m.def("read_bandwidth", &read_bandwidth, "bytes"_a, "threads"_a = 1, "repeats"_a = 7);
    bind_subdivision(m);
}
