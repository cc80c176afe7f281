// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/options.h"
#include "native/caging/automatic_cage.h"
#include "native/caging/cage_diagnosis.h"

namespace sinew::bindings {

namespace {

py::array_t<int> pair_array(const std::vector<std::array<int, 2>>& pairs)
{
    return py::array_t<int>({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}},
                            pairs.empty() ? nullptr : pairs.front().data());
}

py::tuple make_cage(const SurfaceMesh& mesh, int faces, double margin,
                    const Chosen<AutomaticCageOptions::Symmetry>& symmetry, bool quads,
                    const Callback& progress)
{
    AutomaticCageOptions options{.faces = faces, .margin = margin, .quads = quads};
    options.symmetry = symmetry.value("symmetry");
    const Progress ticks = bindings::progress(progress);
    AutomaticCage cage;
    {
        const py::gil_scoped_release unlocked;
        cage = automatic_cage(mesh, options, ticks);
    }
    py::object polygons = py::make_tuple(to_numpy(cage.counts), to_numpy(cage.corners));
    if (!quads)
        polygons = py::array_t<int>({static_cast<py::ssize_t>(cage.counts.size()), py::ssize_t{3}},
                                    cage.corners.data());
    return py::make_tuple(to_numpy(std::move(cage.points)), polygons, cage.report);
}

} // namespace

void bind_automatic_cage(py::module_& module)
{
    py::class_<AutomaticCageReport>(module, "AutomaticCageReport",
                                    "What automatic_cage() did; lengths are shares of the target's size.")
        .def_readonly("wanted", &AutomaticCageReport::wanted, "Number of triangles asked for.")
        .def_readonly("faces", &AutomaticCageReport::faces, "Number of triangles; a quad counts as two.")
        .def_readonly("quads", &AutomaticCageReport::quads, "How many pairs of these triangles are quads.")
        .def_readonly("reached", &AutomaticCageReport::reached,
                      "Whether there are no more faces than wanted; one more in a symmetric cage.")
        .def_readonly("reason", &AutomaticCageReport::reason,
                      "Why there are more faces than wanted; empty where the number was reached.")
        .def_readonly("mirror_axis", &AutomaticCageReport::mirror_axis, "0 to 2, or -1 for none.")
        .def_readonly(
            "asymmetry", &AutomaticCageReport::asymmetry,
            "The greatest distance from the mirror image of a vertex to the target, for the best axis\n"
            "or the one asked for; 0 where no symmetry is wanted.")
        .def_readonly("wrap_faces", &AutomaticCageReport::wrap_faces,
                      "Number of triangles of the fine surface that was simplified.")
        .def_readonly("margin", &AutomaticCageReport::margin,
                      "The margin of that surface, more than wanted where the target has many holes.")
        .def_readonly("clearance", &AutomaticCageReport::clearance,
                      "Distance of the cage from the closest vertex of the target.")
        .def_readonly("seconds", &AutomaticCageReport::seconds, "Wall clock time of the call.")
        .def("__repr__", [](const AutomaticCageReport& report) {
            return "<AutomaticCageReport: " + std::to_string(report.faces) + " of " +
                   std::to_string(report.wanted) + " faces, clearance " + std::to_string(report.clearance) +
                   (report.reached ? ">" : "; " + report.reason + ">");
        });

    module.def("automatic_cage", &make_cage, py::arg("mesh"), py::arg("faces") = 300,
               py::arg("margin") = 1.0 / 60.0, py::kw_only(), py::arg("symmetry") = "automatic",
               py::arg("quads") = false, py::arg("progress") = py::none(), R"(
Make a coarse cage around any mesh. It is closed, does not cross itself, looks outward, and has the whole mesh
inside; all this is checked.

mesh      SurfaceMesh, with any parts, holes and crossings; loose vertices count nothing beside faces.
faces     number of triangles wanted, 12 to 100000; a quad counts as two. There may be more: the report says how
          many, and why.
margin    distance from the mesh at which the cage is begun, as a share of its size (SurfaceMesh.sizes, of all
          parts together); 0.004 to 0.25.
symmetry  'automatic' (along the axis along which the sides differ least, if by no more than 0.02 of the size),
          'none', 'x', 'y' or 'z'. About the object's origin if the target is symmetric about it, else about the
          its centroid. Vertices come in pairs, mirrored exactly about the origin, else to rounding.
quads     join triangles into quads where the cage is good with either diagonal.
progress  None or callable(fraction, stage); returning False cancels.

Returns (points (n, 3), faces (m, 3) or, with quads, (counts, indices), AutomaticCageReport).
Cost: grows as 1 / margin^2; about 1 s with the default margin. Raises InvalidMesh where no good cage is found,
InvalidOption or Cancelled.)");

    py::class_<CageDiagnosis>(module, "CageDiagnosis",
                              "What keeps a mesh from being a good cage, by element.")
        .def_property_readonly(
            "open_edges", [](const CageDiagnosis& d) { return pair_array(d.open_edges); },
            "(k, 2) vertices of edges with one face.")
        .def_property_readonly(
            "non_manifold_edges", [](const CageDiagnosis& d) { return pair_array(d.non_manifold_edges); },
            "(k, 2) vertices of edges with three or more faces.")
        .def_property_readonly(
            "crowded_diagonals", [](const CageDiagnosis& d) { return pair_array(d.crowded_diagonals); },
            "(k, 2) vertices of diagonals that are edges, too, or diagonals of several faces: cut along "
            "them, "
            "more than\n"
            "two triangles meet there.")
        .def_property_readonly(
            "inverted_faces", [](const CageDiagnosis& d) { return to_numpy(d.inverted_faces); },
            "(k,) faces that look inward and should be flipped.")
        .def_property_readonly(
            "degenerate_faces", [](const CageDiagnosis& d) { return to_numpy(d.degenerate_faces); },
            "(k,) faces with a triangle without area.")
        .def_property_readonly(
            "crossing_faces", [](const CageDiagnosis& d) { return pair_array(d.crossing_faces); },
            "(k, 2) pairs of faces that meet elsewhere than at common corners.")
        .def_property_readonly(
            "outside_points", [](const CageDiagnosis& d) { return to_numpy(d.outside_points); },
            "(k,) points outside the cage.")
        .def_readonly("component_count", &CageDiagnosis::component_count, "Connected parts with faces.")
        .def_property_readonly(
            "clean", [](const CageDiagnosis& d) { return summary(d) == "clean"; }, "Nothing is wrong.")
        .def(
            "summary", [](const CageDiagnosis& d) { return summary(d); },
            "One line with the counts, or 'clean'.")
        .def("__repr__", [](const CageDiagnosis& d) { return "<CageDiagnosis: " + summary(d) + ">"; });

    module.def(
        "diagnose_cage",
        [](const SurfaceMesh& cage, const ArrayLike& object) {
            if (object.is_none()) {
                const py::gil_scoped_release unlocked;
                return diagnose_cage(cage);
            }
            const FloatArray array = floats(object, "points");
            const PointsView target = points<InvalidConstraint>(array, "points");
            const py::gil_scoped_release unlocked;
            return diagnose_cage(cage, target);
        },
        py::arg("cage"), py::arg("points") = py::none(), R"(
What is wrong with a cage, and which of the points (n, 3) of its target lie outside, by element index.

Cost: points times faces. Raises InvalidConstraint for NaN or infinite points.)");
}

} // namespace sinew::bindings
