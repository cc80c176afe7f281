// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/handle_points.h"
#include "native/bindings/lattice.h"
#include "native/bindings/method_binding.h"
#include "native/methods/space/lattice/inverse_ffd.h"

#include <memory>

namespace sinew::bindings {

namespace {

std::shared_ptr<InverseFfd> make_inverse_ffd(const ArrayLike& handles, const OptionalArray& counts,
                                             const OptionalArray& weights, const OptionalArray& resolution,
                                             const std::string& basis, int degree, double cut_off,
                                             const OptionalArrayOrMesh& frame)
{
    InverseFfdOptions options;
    options.resolution = three_counts(resolution, "resolution");
    options.basis = spline_or_bezier(basis, false);
    options.degree = degree;
    options.cut_off = cut_off;
    if (!counts.is_none())
        options.counts = integers(counts, "counts");
    if (!weights.is_none())
        options.weights = numbers(weights, "weights");
    if (py::isinstance<SurfaceMesh>(frame)) {
        options.frame = InverseFfd::box_around(frame.cast<const SurfaceMesh&>());
    } else if (!frame.is_none()) {
        const FloatArray box = floats(frame, "frame");
        if (box.ndim() != 2 || box.shape(0) != 3 || box.shape(1) != 4)
            throw InvalidOption("frame: give the affine map of a cube, (3, 4) numbers");
        options.frame = Eigen::Map<const Pose>(box.data());
    }
    const FloatArray array = floats(handles, "points");
    const PointsView view = points<InvalidConstraint>(array, "points");
    const py::gil_scoped_release unlocked;
    return std::make_shared<InverseFfd>(view, options);
}

py::array_t<double> inverse_moves(const InverseFfd& method, const ArrayLike& posed)
{
    const FloatArray array = floats(posed, "posed");
    const PointsView view = points<InvalidConstraint>(array, "posed");
    Points moves;
    {
        const py::gil_scoped_release unlocked;
        moves = method.control_moves(view);
    }
    return to_numpy(std::move(moves));
}

void bind_inverse_ffd(py::module_& module)
{
    py::class_<InverseFfd, SpaceMethod, std::shared_ptr<InverseFfd>> method(
        module, "InverseFfd", R"(Inverse free-form deformation [Hsu, Hughes & Kaufman 1992], section 5.1.

Points of the shape are dragged, and the control points of a lattice around it move as little as they can: by least
squares where they cannot meet all constraints, by least norm where they can. What is far from all constraints stays.
The cost of a bind is O(points), and that of the eigenvectors of a matrix of as many rows as there are constraints or
control points, whichever are fewer.)");
    define_warp_poses(method, &HandlePoints::posed_points);
    method
        .def(py::init(&make_inverse_ffd), py::arg("points"), py::arg("counts") = py::none(), py::kw_only(),
             py::arg("weights") = py::none(), py::arg("resolution") = 5, py::arg("basis") = "bspline",
             py::arg("degree") = 3, py::arg("cut_off") = 1e-3, py::arg("frame") = py::none(), R"(
points      (c, 3) the constraints at rest: places of the shape that will be dragged.
counts      (k,) how many constraints each handle has, which one pose of warp_poses() moves; None if each is a handle.
weights     None (1), or (c,) in (0, 1]: how much the squared errors count where not all constraints can be met.
resolution  control points of the lattice along each axis, 2 to 16: one number, or three.
basis       'bspline' or 'bezier'.
degree      of B-splines, 1 to 5; axes with fewer points have a lower one.
cut_off     singular values below this share of the largest count as zero: between 0 and 1.
frame       None, for a box around the bound points and the constraints, along the axes in which they are spread most
            and least; a SurfaceMesh, for such a box around its faces; or (3, 4), whose image of the cube from -1 to 1
            is the box.

Raises InvalidConstraint if there is no constraint, one is not finite, or the weights or counts do not fit; InvalidOption.)")
        .def_property_readonly(
            "lattice",
            [](const InverseFfd& method) {
                Points lattice;
                {
                    const py::gil_scoped_release unlocked;
                    lattice = method.lattice();
                }
                return to_numpy(std::move(lattice));
            },
            "(l, 3) the control points at rest; none before bind().")
        .def_property_readonly("rank", &InverseFfd::rank,
                               "How many independent motions the constraints have, at most c.")
        .def("control_moves", &inverse_moves, py::arg("posed"),
             R"(How far the control points move -> (l, 3).

posed  (c, 3) where the constraints are dragged.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, or before bind().)")
        .def("__repr__", [](const py::object& self) { return representation(self, "an inverse lattice"); });
}

const MethodBinding inverse_ffd_binding(&bind_inverse_ffd);

} // namespace

} // namespace sinew::bindings
