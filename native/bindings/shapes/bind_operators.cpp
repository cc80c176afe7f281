// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/options.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/operators/gradient.h"
#include "native/operators/laplacian.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

py::array_t<double> fit_rotations(const ArrayLike& object)
{
    const FloatArray S = floats(object, "S");
    if (S.ndim() != 3 || S.shape(1) != 3 || S.shape(2) != 3)
        throw InvalidOption("S: the shape must be (k, 3, 3)");
    using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    py::array_t<double> R({S.shape(0), py::ssize_t{3}, py::ssize_t{3}});
    for (py::ssize_t k = 0; k < S.shape(0); ++k) {
        const Eigen::Map<const RowMatrix3> in(S.data() + 9 * k);
        if (!in.allFinite())
            throw InvalidOption("S: NaN or infinite entry in matrix " + std::to_string(k));
        Eigen::Map<RowMatrix3>(R.mutable_data() + 9 * k) = fit_rotation(in);
    }
    return R;
}

} // namespace

void bind_operators(py::module_& module)
{
    module.def(
        "laplacian",
        [](const SurfaceMesh& mesh, const Chosen<Discretization>& kind) {
            return laplacian_matrix(mesh, kind.value("laplacian"));
        },
        py::arg("mesh"), py::arg("discretization") = "cotan_voronoi",
        R"((n, n) SciPy sparse L: symmetric, positive semi-definite, weak (not divided by area).

(L f)_i = sum_j w_ij (f_i - f_j) with the weights of tutorial section 3.2: 'uniform' [Tau95],
'cotan' [YZX*04] or 'cotan_voronoi' [MDSB03]. The Laplace-Beltrami of f is -(L f) / mass.)");
    module.def(
        "mass",
        [](const SurfaceMesh& mesh, const Chosen<Discretization>& kind) {
            return mass_vector(mesh, kind.value("laplacian"));
        },
        py::arg("mesh"), py::arg("discretization") = "cotan_voronoi",
        "(n,) mass of each vertex: mixed Voronoi area, 1, or the number of neighbours ('uniform').");
    module.def(
        "laplacian_power",
        [](const SurfaceMesh& mesh, int order, const Chosen<Discretization>& kind) {
            return laplacian_power(mesh, order, kind.value("laplacian"));
        },
        py::arg("mesh"), py::arg("order"), py::arg("discretization") = "cotan_voronoi",
        "(n, n) symmetric operator of order k, L (M^-1 L)^(k-1), Eq. 18. Raises InvalidOption below order "
        "1,\n"
        "InvalidMesh where the mesh is so large or small that no entry can be computed.");
    module.def("gradient", &gradient_matrix, py::arg("mesh"),
               "(3t, n) sparse G: rows 3k..3k+2 are the gradient on triangle k.");
    module.def(
        "divergence", &divergence_matrix, py::arg("mesh"),
        "(n, 3t) sparse G^T D, where D has the areas of the triangles; divergence @ gradient = cotan L.");
    module.def("fit_rotations", &fit_rotations, py::arg("S"),
               "(k, 3, 3) -> (k, 3, 3) rotations R (det +1) that maximise trace(R^T S); exact for "
               "reflected and rank-deficient S. Raises InvalidOption for another shape.");
}

} // namespace sinew::bindings
