// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/choices.h"
#include "native/space/cage/green.h"
#include "native/space/cage/harmonic.h"
#include "native/space/cage/mean_value.h"
#include "native/space/cage/positive_mean_value.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>

namespace sinew::bindings {

namespace {

PointWeightOptions weight_options(const std::string& precision, double threshold)
{
    return {choose<WeightPrecision>(precision, "precision",
                                    {{"single", WeightPrecision::single_precision},
                                     {"double", WeightPrecision::double_precision}}),
            threshold};
}

py::object warp(const CageCoordinates& coordinates, const py::object& vertices, const py::object& out)
{
    const FloatArray array = floats(vertices, "cage_points");
    const PointsView view = points<InvalidConstraint>(array, "cage_points");
    if (!out.is_none()) {
        SinglePoints single = singles(out, "out", coordinates.points().rows());
        const py::gil_scoped_release unlocked;
        coordinates.warp(view, single.data());
        require_finite(single);
        return out;
    }
    Points positions;
    {
        const py::gil_scoped_release unlocked;
        coordinates.warp(view, positions);
    }
    return to_numpy(std::move(positions));
}

CageOutside cage_outside(const std::string& outside)
{
    return choose<CageOutside>(outside, "outside",
                               {{"error", CageOutside::refuse}, {"mean_value", CageOutside::mean_value}});
}

/// One class a method, with the options that all of them take.
template <class Method>
py::class_<Method, CageCoordinates> bind_method(py::module_& module, const char* name, const char* doc)
{
    return py::class_<Method, CageCoordinates>(module, name, doc)
        .def(py::init([](const SurfaceMesh& cage, const std::string& precision, double threshold) {
                 const PointWeightOptions options = weight_options(precision, threshold);
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<Method>(Cage(cage), options);
             }),
             py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0, R"(
cage       SurfaceMesh, the closed rest cage, faces outwards.
precision  of the weights kept: 'single' (half the memory and time of a warp) or 'double'.
threshold  weights of a smaller magnitude are dropped, the others changed so that their sum stays,
           and stored sparsely; 0 keeps all, densely.

Raises InvalidMesh for a cage that is open, flat or inside out; InvalidOption.)");
}

} // namespace

void bind_cage(py::module_& module)
{
    py::class_<CageReport>(module, "CageReport", "What bind() did.")
        .def_readonly("point_count", &CageReport::point_count, "Points bound.")
        .def_property_readonly(
            "outside", [](const CageReport& report) { return to_numpy(report.outside); },
            "Points outside the cage.")
        .def_readonly(
            "dropped", &CageReport::dropped,
            "What the threshold changed in the weights of a point, at most: times the longest move of "
            "a cage vertex, a bound of how far a warped point is off.")
        .def_readonly("error", &CageReport::error,
                      "Estimate of the largest error of a weight; 0 where the form is closed.")
        .def_readonly("weight_bytes", &CageReport::weight_bytes, "Memory of the weights.")
        .def_readonly("seconds", &CageReport::seconds, "Wall clock of bind().");

    py::class_<CageCoordinates>(module, "CageCoordinates", "What every cage method can do.")
        .def(
            "bind",
            [](CageCoordinates& coordinates, const py::object& rest, const py::object& callback) {
                const FloatArray array = floats(rest, "points");
                const PointsView view = points<InvalidConstraint>(array, "points");
                const Progress ticks = progress(callback);
                const py::gil_scoped_release unlocked;
                return coordinates.bind(view, ticks);
            },
            py::arg("points"), py::arg("progress") = py::none(),
            R"(Compute the weights of points -> CageReport.

points    (n, 3) rest points, in the frame of the cage.
progress  None or callable(fraction, stage); returning False cancels.

Raises InvalidConstraint (points not finite, or where the method has no weights), OutOfMemory or Cancelled;
the object then stays as it was.)")
        .def("warp", &warp, py::arg("cage_points"), py::arg("out") = py::none(),
             R"(Where a posed cage takes the bound points -> (n, 3).

cage_points  (c, 3) posed cage vertices.
out          None, or a writable C-contiguous (n, 3) float32 array to write into, which is returned.

The rest cage gives the rest points back to the last bit.

Raises InvalidConstraint for a wrong count or shape, a number that is not finite, or before bind().)")
        .def(
            "influence",
            [](const CageCoordinates& coordinates, std::vector<int> vertices) {
                std::sort(vertices.begin(), vertices.end());
                vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
                const int count = coordinates.cage().vertex_count();
                for (int vertex : vertices)
                    if (vertex < 0 || vertex >= count)
                        throw InvalidConstraint("vertices: the cage has no vertex " + std::to_string(vertex),
                                                Error::Element::vertex, {vertex});
                return coordinates.weights().sum(vertices);
            },
            py::arg("vertices"),
            R"(How far each point goes with some vertices of the cage -> (n,) the sum of their weights.

vertices  indices; one that comes twice counts once. Cost: O(points x vertices), sparse O(weights).

Raises InvalidConstraint for an index that the cage does not have.)")
        .def_property_readonly(
            "vertex_weights",
            [](const CageCoordinates& coordinates) {
                const RowMatrix dense = coordinates.weights().dense();
                return RowMatrix(
                    dense.leftCols(std::min<Eigen::Index>(coordinates.cage().vertex_count(), dense.cols())));
            },
            "(n, c) weights of the cage's vertices.");

    py::class_<Green, CageCoordinates>(module, "Green",
                                       R"(Green coordinates [Lipman, Levin & Cohen-Or 2008], section 5.4.

Shapes are kept: similarities of the cage are reproduced, shears are not. A closed form: cost
O(points x triangles).)")
        .def(py::init([](const SurfaceMesh& cage, const std::string& precision, double threshold,
                         const std::string& outside, int exit_face) {
                 GreenOptions options;
                 options.weights = weight_options(precision, threshold);
                 options.outside = choose<GreenOutside>(outside, "outside",
                                                        {{"nearest", GreenOutside::nearest},
                                                         {"face", GreenOutside::face},
                                                         {"error", GreenOutside::refuse}});
                 options.exit_face = exit_face;
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<Green>(Cage(cage), options);
             }),
             py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0,
             py::arg("outside") = "nearest", py::arg("exit_face") = -1, R"(
cage       SurfaceMesh, the closed rest cage, faces outwards.
precision  of the weights kept: 'single' (half the memory and time of a warp) or 'double'.
threshold  weights of a smaller magnitude are dropped, the others changed so that their sum stays,
           and stored sparsely; 0 keeps all, densely.
outside    what becomes of points outside: continued through the 'nearest' triangle, through one 'face', or
           an 'error' that names them.
exit_face  of the cage, for outside='face'.

Raises InvalidMesh for a cage that is open, flat or inside out; InvalidOption.)")
        .def_property_readonly(
            "face_weights", &Green::face_weights,
            "(n, t) weights of the normals of the triangles that the cage's faces are cut into, "
            "in the cage's units of length.");

    bind_method<MeanValue>(module, "MeanValue",
                           R"(Mean value coordinates [Ju, Schaefer & Warren 2005], section 5.4.

Sum 1 and linear precision everywhere, outside the cage too; may be negative where a concave cage is seen
through itself. A closed form: cost O(points x triangles).)");

    py::class_<Harmonic, CageCoordinates>(
        module, "Harmonic",
        R"(Harmonic coordinates [Joshi et al. 2007], section 5.4, by boundary elements or on a cut lattice.

Non-negative, sum 1, linear precision, no maximum inside. Up to 600 triangles, the first bind() solves the
cage's boundary; with more, each bind() solves a lattice inside.)")
        .def(py::init([](const SurfaceMesh& cage, const std::string& precision, double threshold,
                         const std::string& quality, const std::string& outside, const std::string& solver) {
                 HarmonicOptions options;
                 options.weights = weight_options(precision, threshold);
                 options.quality = choose<HarmonicQuality>(quality, "quality",
                                                           {{"fast", HarmonicQuality::fast},
                                                            {"medium", HarmonicQuality::medium},
                                                            {"fine", HarmonicQuality::fine},
                                                            {"finest", HarmonicQuality::finest}});
                 options.outside = cage_outside(outside);
                 options.solver = choose<HarmonicSolver>(solver, "solver",
                                                         {{"auto", HarmonicSolver::automatic},
                                                          {"boundary", HarmonicSolver::boundary},
                                                          {"lattice", HarmonicSolver::lattice}});
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<Harmonic>(Cage(cage), options);
             }),
             py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0,
             py::arg("quality") = "medium", py::arg("outside") = "error", py::arg("solver") = "auto", R"(
cage       SurfaceMesh, the closed rest cage, faces outwards.
precision  of the weights kept: 'single' (half the memory and time of a warp) or 'double'.
threshold  weights of a smaller magnitude are dropped, the others stored sparsely; 0 keeps all.
quality    'fast', 'medium', 'fine' or 'finest': at most 1000, 2000, 4100 or 12000 unknowns on the cage, whose
           cube is the time and whose square the memory; or 96, 160, 256 or 384 steps of the lattice along
           the cage's longest side.
outside    points outside: 'error' names them, 'mean_value' gives them mean value weights.
solver     'boundary' elements or a 'lattice'; 'auto' takes the lattice beyond 600 triangles.

Raises InvalidMesh for a cage that is open, flat or inside out; InvalidOption. With boundary elements, bind()
also raises InvalidMesh for faces without area and faces that touch one another.)")
        .def_property_readonly("unknowns", &Harmonic::unknowns,
                               "Unknowns of the boundary's flux or nodes of the lattice, once bound.")
        .def_property_readonly(
            "residual_rms", &Harmonic::residual_rms,
            "Root mean square gap of the weights to the data on the cage, once bound; 0 on a "
            "lattice.")
        .def_property_readonly("residual_max", &Harmonic::residual_max,
                               "The largest one, a bound of the error anywhere but for its sampling.");

    py::class_<PositiveMeanValue, CageCoordinates>(
        module, "PositiveMeanValue",
        R"(Positive mean value coordinates [Lipman et al. 2007], section 5.4: of what each point sees of the cage.

Non-negative, sum 1, linear precision; mean values in a convex cage. Continuous, but their gradients jump
where an edge of the cage comes into view.)")
        .def(py::init([](const SurfaceMesh& cage, const std::string& precision, double threshold, bool exact,
                         int directions, const std::string& outside) {
                 PositiveMeanValueOptions options;
                 options.weights = weight_options(precision, threshold);
                 options.exact = exact;
                 options.directions = directions;
                 options.outside = cage_outside(outside);
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<PositiveMeanValue>(Cage(cage), options);
             }),
             py::arg("cage"), py::kw_only(), py::arg("precision") = "single", py::arg("threshold") = 0.0,
             py::arg("exact") = true, py::arg("directions") = 1024, py::arg("outside") = "error", R"(
cage        SurfaceMesh, the closed rest cage, faces outwards.
precision   of the weights kept: 'single' (half the memory and time of a warp) or 'double'.
threshold   weights of a smaller magnitude are dropped, the others stored sparsely; 0 keeps all.
exact       by cutting away what is hidden; False: by rays, a preview whose weights jump by some 1e-3.
directions  rays a point, an even number of at least 8.
outside     points outside: 'error' names them, 'mean_value' gives them mean value weights.

Raises InvalidMesh for a cage that is open, flat or inside out; InvalidOption.)");
}

} // namespace sinew::bindings
