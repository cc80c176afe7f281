// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/lattice.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/lattice/ffd.h"

#include <cmath>
#include <memory>

namespace sinew::bindings {

namespace {

std::array<int, 3> ffd_resolution(const ArrayLike& given, Eigen::Index count)
{
    if (!given.is_none())
        return three_counts(given, "resolution");
    const int side = static_cast<int>(std::lround(std::cbrt(static_cast<double>(count))));
    if (static_cast<Eigen::Index>(side) * side * side != count)
        throw InvalidOption("resolution: say how " + std::to_string(count) +
                            " points are arranged; they are no cube");
    return {side, side, side};
}

std::array<LatticeBasis, 3> ffd_basis(const std::string& basis, const OptionalArray& interpolation)
{
    std::array<LatticeBasis, 3> found;
    if (basis != "blender") {
        found.fill(spline_or_bezier(basis, true));
        return found;
    }
    const auto names = py::isinstance<py::str>(interpolation)
                           ? std::vector<std::string>(3, interpolation.cast<std::string>())
                           : interpolation.cast<std::vector<std::string>>();
    if (names.size() != 3)
        throw InvalidOption("interpolation: give one name, or three, not " + std::to_string(names.size()));
    for (std::size_t axis = 0; axis < 3; ++axis)
        found[axis] = choose<LatticeBasis>(names[axis], "interpolation",
                                           {{"linear", LatticeBasis::linear},
                                            {"cardinal", LatticeBasis::cardinal},
                                            {"catmull_rom", LatticeBasis::catmull_rom},
                                            {"bspline", LatticeBasis::blender_spline}});
    return found;
}

std::shared_ptr<Ffd> make_ffd(const ArrayOrMesh& points_or_mesh, const OptionalArray& resolution,
                              const std::string& basis, int degree, const OptionalArray& interpolation,
                              const std::string& outside, int continuity, int smooth, const ArrayLike& axes)
{
    RestGridOptions options;
    options.basis = ffd_basis(basis, interpolation);
    options.degree = degree;
    options.outside = choose<LatticeOutside>(
        outside, "outside", {{"follow", LatticeOutside::follow}, {"freeze", LatticeOutside::freeze}});
    options.continuity = continuity;
    if (!axes.is_none()) {
        const FloatArray rows = floats(axes, "axes");
        if (rows.ndim() != 2 || rows.shape(0) != 3 || rows.shape(1) != 3)
            throw InvalidOption("axes: give the directions of the three axes, (3, 3) numbers");
        options.axes = Eigen::Map<const Matrix3>(rows.data()); // column-major: rows become columns
    }
    if (py::isinstance<SurfaceMesh>(points_or_mesh)) {
        const auto& mesh = points_or_mesh.cast<const SurfaceMesh&>();
        const py::gil_scoped_release unlocked;
        return std::make_shared<Ffd>(Hexahedra(mesh, smooth));
    }
    const FloatArray array = floats(points_or_mesh, "points");
    const PointsView view = points<InvalidMesh>(array, "points");
    const std::array<int, 3> counts = ffd_resolution(resolution, view.rows());
    const py::gil_scoped_release unlocked;
    return std::make_shared<Ffd>(RestGrid(view, counts, options));
}

void bind_ffd(py::module_& module)
{
    py::class_<Ffd, SpaceMethod, std::shared_ptr<Ffd>>(
        module, "Ffd", R"(Free-form deformation [Sederberg & Parry 1986; Coquillart 1990], section 5.1.

A lattice of control points moves what lies in it, by Bernstein polynomials, B-splines, or the four functions of
Blender's lattices. Hexahedra of any topology [MacCracken & Joy 1996] come as a SurfaceMesh. A point costs 64 products
with cubics; no weights are stored.)")
        .def(py::init(&make_ffd), py::arg("points"), py::kw_only(), py::arg("resolution") = py::none(),
             py::arg("basis") = "bspline", py::arg("degree") = 3, py::arg("interpolation") = "bspline",
             py::arg("outside") = "follow", py::arg("continuity") = 1, py::arg("smooth") = 1,
             py::arg("axes") = py::none(), R"(
points         (c, 3) the control points at rest, in rows along u, then v, then w, as Blender orders them; or a
               SurfaceMesh whose faces are the sides of hexahedra.
resolution     None, for as many along each axis, or (u, v, w) control points.
basis          'bspline', 'bezier' (the degree is one below the number of points, which is at most 16), or
               'blender'.
degree         of B-splines, 1 to 5; axes with fewer points have a lower one.
interpolation  with 'blender', the function along all axes: 'linear', 'cardinal', 'catmull_rom' or 'bspline'; or three.
outside        'follow': the functions go on as straight lines; 'freeze': some planes beside each border and all
               points outside stay. Blender's functions are constant there.
continuity     k from 0 to 4: with 'freeze', k + 1 planes stay, so that k derivatives are continuous.
smooth         steps of subdivision of hexahedra, 0 to 4.
axes           None, or (3, 3): the directions u, v and w of axes that have one point only, along which nothing changes;
               None for those across the others.

Raises InvalidMesh for a lattice that is flat or folded, or not finite, and names its points; InvalidOption.)")
        .def_property_readonly("control_count", &Ffd::control_count, "Number of control points.")
        .def("__repr__", [](const py::object& self) {
            return representation(
                self, "a lattice of " + std::to_string(self.cast<const Ffd&>().control_count()) + " points");
        });
}

const MethodBinding ffd_binding(&bind_ffd);

} // namespace

} // namespace sinew::bindings
