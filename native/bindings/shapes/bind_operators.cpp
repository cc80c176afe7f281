// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/options.h"
#include "native/operators/curvature.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/operators/fits/turned_poses.h"
#include "native/operators/gradient.h"
#include "native/operators/laplacian.h"

#include <pybind11/eigen.h>

#include <algorithm>
#include <string>

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

py::array_t<double> turned(const ArrayLike& rest, const ArrayLike& posed, const OptionalArray& edges)
{
    const FloatArray before = floats(rest, "rest"), after = floats(posed, "posed");
    const PointsView from = points<InvalidConstraint>(before, "rest"),
                     to = points<InvalidConstraint>(after, "posed");
    const auto lines = edges.is_none() ? std::vector<std::array<int, 2>>{} : index_pairs(edges, "edges");
    Poses poses;
    {
        const py::gil_scoped_release unlocked;
        poses = turned_poses(from, to, lines);
    }
    py::array_t<double> result({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}, py::ssize_t{4}});
    for (std::size_t i = 0; i < poses.size(); ++i)
        std::copy_n(poses[i].data(), 12, result.mutable_data() + 12 * i);
    return result;
}

/// (n, k) from k columns.
template <std::size_t k>
py::array_t<double> in_columns(const std::array<VectorX, k>& values)
{
    py::array_t<double> result({values[0].size(), static_cast<Eigen::Index>(k)});
    auto entries = result.mutable_unchecked<2>();
    for (Eigen::Index i = 0; i < values[0].size(); ++i)
        for (std::size_t j = 0; j < k; ++j)
            entries(i, static_cast<Eigen::Index>(j)) = values[j][i];
    return result;
}

/// (n, 2, 2) symmetric matrices from their entries.
py::array_t<double> symmetric_forms(const std::array<VectorX, 3>& entries)
{
    const auto& [uu, uv, vv] = entries;
    return in_columns(std::array{uu, uv, uv, vv}).reshape({uu.size(), Eigen::Index{2}, Eigen::Index{2}});
}

/// (n, 2, 3) from two vectors each.
py::array_t<double> two_vectors(const std::array<Points, 2>& vectors)
{
    const Eigen::Index n = vectors[0].rows();
    RowMatrix both(n, 6);
    both << vectors[0], vectors[1];
    return py::array_t<double>(both.size(), both.data()).reshape({n, Eigen::Index{2}, Eigen::Index{3}});
}

void bind_curvature(py::module_& module)
{
    py::class_<Curvature>(module, "Curvature", R"(How a surface bends at each vertex (tutorial, section 3.1).

Units are 1 / length, of `gaussian` 1 / area. Where faces look outward, convex places have positive curvatures: a sphere
of radius r has the mean curvature 1 / r. A vertex in no face has 0 everywhere.)")
        .def_readonly(
            "mean", &Curvature::mean,
            "(n,) H, Eq. 4, from the Laplacian; from the fit at borders and edges of three or more faces.")
        .def_readonly(
            "gaussian", &Curvature::gaussian,
            "(n,) K, Eq. 3, from the angles around the vertex; from the fit where `mean` is. Of a closed\n"
            "surface, the sum of mass * gaussian is 2 pi times the Euler characteristic.")
        .def_property_readonly(
            "principal", [](const Curvature& c) { return in_columns(c.principal); },
            "(n, 2) the smallest and the largest normal curvature, from the fit.")
        .def_property_readonly(
            "directions", [](const Curvature& c) { return two_vectors(c.directions); },
            "(n, 2, 3) unit tangents along which `principal` are, with the normal a right-handed frame. "
            "Where both\n"
            "are the same, any direction is one.")
        .def_property_readonly(
            "normals", [](const Curvature& c) { return Points(c.normals); },
            "(n, 3) unit normals of the fit, to the side that the faces look to.")
        .def_property_readonly(
            "tangents", [](const Curvature& c) { return two_vectors(c.tangents); },
            "(n, 2, 3) x_u and x_v, of a parametrisation of the fit.")
        .def_property_readonly(
            "first_form", [](const Curvature& c) { return symmetric_forms(c.first_form); },
            "(n, 2, 2) I, Eq. 1, of these tangents.")
        .def_property_readonly(
            "second_form", [](const Curvature& c) { return symmetric_forms(c.second_form); },
            "(n, 2, 2) II, minus Eq. 2, so that convex places are positive.")
        .def(
            "along",
            [](const Curvature& c, const ArrayLike& directions) {
                const FloatArray array = floats(directions, "directions");
                return c.along(points<InvalidOption>(array, "directions"));
            },
            py::arg("directions"), R"((n,) the normal curvature in a direction per vertex, t II t / t I t.

directions  (n, 3) of any length; only what is tangential counts. 0 where nothing is.

Raises InvalidOption for another shape or a number that is not finite.)")
        .def("__repr__", [](const Curvature& c) {
            return "<Curvature: " + std::to_string(c.mean.size()) + " vertices, mean from " +
                   std::to_string(c.mean.minCoeff()) + " to " + std::to_string(c.mean.maxCoeff()) + ">";
        });

    module.def("curvature", &curvature, py::arg("mesh"), py::arg("rings") = 2,
               py::call_guard<py::gil_scoped_release>(), R"(Curvatures of each vertex -> Curvature.

rings  how many rings of neighbours are fitted, >= 1. More smooth noise, and blur what is smaller. Where they hold less
       than 15 vertices, as at borders, further rings are added.

`mean` and `gaussian` are those of M. Meyer et al., "Discrete Differential-Geometry Operators for Triangulated
2-Manifolds", 2003, Eqs. 8 and 9: their sums over a region are exact, and each converges where faces are regular. All
else is of a cubic fitted to the neighbours, F. Cazals and M. Pouget, "Estimating Differential Quantities Using
Polynomial Fitting of Osculating Jets", 2005: its errors fall to a quarter where edges halve, on any mesh.

Raises InvalidOption for rings below 1. Cost: O(n), a least-squares fit per vertex.)");
}

} // namespace

void bind_operators(py::module_& module)
{
    bind_curvature(module);
    module.def(
        "laplacian",
        [](const SurfaceMesh& mesh, const Chosen<Discretization>& kind) {
            return laplacian_matrix(mesh, kind.value("laplacian"));
        },
        py::arg("mesh"), py::arg("discretization") = "cotan_voronoi",
        R"((n, n) SciPy sparse L: symmetric, positive semi-definite, weak (not divided by area).

(L f)_i = sum_j w_ij (f_i - f_j) with the weights of tutorial section 3.2: 'uniform' [Tau95],
'cotan' [YZX*04] or 'cotan_voronoi' [MDSB03]. The Laplace-Beltrami of f is -(L f) / mass.

'robust' has no negative weight on any mesh (but for rounding): it is 'cotan_voronoi' of the intrinsic Delaunay
triangulation of both sides of the surface, N. Sharp and K. Crane, "A Laplacian for Nonmanifold Triangle Meshes",
2020. On clean meshes that are Delaunay, both are the same to the last bit. Its neighbours need not be those of the
mesh.

Raises InvalidOption for another name. Cost: O(n), 'robust' O(n log n).)");
    module.def(
        "mass",
        [](const SurfaceMesh& mesh, const Chosen<Discretization>& kind) {
            return mass_vector(mesh, kind.value("laplacian"));
        },
        py::arg("mesh"), py::arg("discretization") = "cotan_voronoi",
        "(n,) mass of each vertex: mixed Voronoi area, 1 ('cotan'), or the number of neighbours "
        "('uniform').");
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
    module.def(
        "turned_poses", &turned, py::arg("rest"), py::arg("posed"), py::arg("edges") = py::none(),
        R"(How points turn that are only known to move -> (n, 3, 4) rigid motions, each from rest to posed.

rest   (n, 3) the points at rest.
posed  (n, 3) where they are.
edges  None, or (e, 2) lines between the points.

A motion turns as the edges at the point do, by the best rotation; a little as all points do, too, which decides where
the edges leave a turn open, and alone for a point without edges.

Raises InvalidConstraint for a wrong shape, a number that is not finite, or an edge of a point that is not there.)");
}

} // namespace sinew::bindings
