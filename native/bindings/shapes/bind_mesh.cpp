// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/core/errors.h"
#include "native/mesh/components.h"
#include "native/mesh/diagnosis.h"
#include "native/mesh/frames/enclosing_ball.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/mesh/surface_mesh.h"
#include "native/mesh/trees/crossing_faces.h"

#include <pybind11/stl.h>

namespace sinew::bindings {

namespace {

struct Faces
{
    std::vector<int> counts, corners;
};

/// Faces from the argument of the constructor in Python.
Faces read_faces(const py::object& faces)
{
    if (py::isinstance<py::tuple>(faces)) {
        const auto pair = faces.cast<py::tuple>();
        if (pair.size() != 2)
            throw InvalidMesh("faces: a tuple must be (counts, indices)");
        return {integers(pair[0], "faces[0]"), integers(pair[1], "faces[1]")};
    }
    const py::array shape = py::array::ensure(faces);
    if (!shape) {
        PyErr_Clear();
        throw InvalidMesh("faces: give an (m, 3) or (m, 4) array, or (counts, indices) for mixed polygons");
    }
    if (shape.size() == 0)
        return {};
    if (shape.ndim() != 2)
        throw InvalidMesh(
            "faces: the array must be (m, 3) or (m, 4); for mixed polygons give (counts, indices)");
    return {std::vector<int>(shape.shape(0), static_cast<int>(shape.shape(1))), integers(faces, "faces")};
}

SurfaceMesh make_mesh(const ArrayLike& point_object, const FaceArrays& face_object)
{
    const FloatArray array = floats(point_object, "points");
    Points copy = points<InvalidMesh>(array, "points");
    Faces faces = read_faces(face_object);
    const py::gil_scoped_release unlocked;
    return SurfaceMesh(std::move(copy), std::move(faces.counts), std::move(faces.corners));
}

bool is_made_of(const SurfaceMesh& mesh, const ArrayLike& point_object, const FaceArrays& face_object)
{
    const FloatArray array = floats(point_object, "points");
    const PointsView given = points<InvalidMesh>(array, "points");
    const Faces faces = read_faces(face_object);
    return mesh.is_made_of(given, faces.counts, faces.corners);
}

/// A read-only (rows, columns) view of memory that `owner` keeps alive.
template <class T>
py::array_t<T> view_of(const T* data, py::ssize_t rows, py::ssize_t columns, const py::object& owner)
{
    py::array_t<T> array({rows, columns}, data, owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

py::array_t<int> edge_array(const std::vector<std::array<int, 2>>& edges)
{
    return py::array_t<int>({static_cast<py::ssize_t>(edges.size()), py::ssize_t{2}},
                            edges.empty() ? nullptr : edges.front().data());
}

} // namespace

void bind_mesh(py::module_& module)
{
    py::class_<Diagnosis>(module, "Diagnosis", "What is unusual about a mesh, as lists of element indices.")
        .def_property_readonly(
            "non_manifold_edges", [](const Diagnosis& d) { return edge_array(d.non_manifold_edges); },
            "(k, 2) vertices of edges with three or more faces.")
        .def_property_readonly(
            "non_manifold_vertices", [](const Diagnosis& d) { return to_numpy(d.non_manifold_vertices); },
            "(k,) vertices whose faces form more than one fan.")
        .def_property_readonly(
            "boundary_loops",
            [](const Diagnosis& d) {
                py::list loops;
                for (const auto& loop : d.boundary_loops)
                    loops.append(to_numpy(loop));
                return loops;
            },
            "List of (l,) vertex arrays, in order along each border.")
        .def_property_readonly(
            "degenerate_faces", [](const Diagnosis& d) { return to_numpy(d.degenerate_faces); },
            "(k,) faces whose area is at most 1e-10 of their longest edge squared.")
        .def_property_readonly(
            "duplicate_faces", [](const Diagnosis& d) { return to_numpy(d.duplicate_faces); },
            "(k,) faces with the same vertices as an earlier face.")
        .def_property_readonly(
            "inconsistent_edges", [](const Diagnosis& d) { return edge_array(d.inconsistent_edges); },
            "(k, 2) edges along which both faces run the same way.")
        .def_property_readonly(
            "flipped_faces", [](const Diagnosis& d) { return to_numpy(d.flipped_faces); },
            "(k,) faces that look to the wrong side: of an open surface those that disagree with most of its "
            "area,\nof a closed one those that look inward, unless most of it does and it lies in the box of "
            "another "
            "closed\none, as the wall of a cavity. None of a one-sided surface, and none that\nis degenerate "
            "or a duplicate.")
        .def_property_readonly(
            "slit_edges", [](const Diagnosis& d) { return edge_array(d.slit_edges); },
            "(k, 2) edges of one face that lie exactly where another such edge lies.")
        .def_property_readonly(
            "loose_vertices", [](const Diagnosis& d) { return to_numpy(d.loose_vertices); },
            "(k,) vertices in no face.")
        .def_property_readonly(
            "coincident_vertices", [](const Diagnosis& d) { return to_numpy(d.coincident_vertices); },
            "(k,) vertices exactly where an earlier vertex is.")
        .def_readonly("component_count", &Diagnosis::component_count, "Number of connected parts.")
        .def_readonly("one_sided_count", &Diagnosis::one_sided_count,
                      "Number of surfaces that have no two sides, such as a Moebius strip.")
        .def_readonly(
            "euler_characteristic", &Diagnosis::euler_characteristic,
            "Vertices with faces - edges + faces: of a closed surface of genus g without defects, 2 - 2 g.")
        .def_property_readonly(
            "clean", [](const Diagnosis& d) { return summary(d) == "clean"; }, "Nothing is unusual.")
        .def(
            "summary", [](const Diagnosis& d) { return summary(d); }, "One line with the counts, or 'clean'.")
        .def("__repr__", [](const Diagnosis& d) { return "<Diagnosis: " + summary(d) + ">"; });

    py::class_<SurfaceMesh>(module, "SurfaceMesh", R"(A rest surface of polygons of any size.

It may have any number of parts, boundaries, non-manifold edges, duplicate faces, faces without area, and loose
vertices. It never changes. Cost: O(n).)")
        .def(py::init(&make_mesh), py::arg("points"), py::arg("faces"), R"(
points  (n, 3) rest positions in object space. No coordinate is above 1e60, and the box around them is no smaller
        than 1e-60, unless all are in one place.
faces   (m, 3) or (m, 4) integers, or a tuple (counts (m,), indices (sum of counts,)).

Raises InvalidMesh for no vertices, NaN, infinite, too large or too small points, faces of fewer than three corners
and indices out of range; `elements` lists the culprits.)")
        .def_property_readonly(
            "points",
            [](const py::object& self) {
                const auto& mesh = self.cast<const SurfaceMesh&>();
                return view_of(mesh.points().data(), mesh.vertex_count(), 3, self);
            },
            "(n, 3) rest positions, read-only.")
        .def_property_readonly(
            "triangles",
            [](const py::object& self) {
                const auto& mesh = self.cast<const SurfaceMesh&>();
                const auto& triangles = mesh.triangles();
                return view_of(triangles.empty() ? nullptr : triangles.front().data(),
                               static_cast<py::ssize_t>(triangles.size()), 3, self);
            },
            "(t, 3) the triangulation that all operators use, read-only.")
        .def_property_readonly("vertex_count", &SurfaceMesh::vertex_count, "Vertices, n.")
        .def_property_readonly("face_count", &SurfaceMesh::face_count, "Faces, m.")
        .def_property_readonly(
            "component_count", [](const SurfaceMesh& m) { return connected_components(m).count; },
            "Connected parts.")
        .def_property_readonly(
            "components", [](const SurfaceMesh& m) { return to_numpy(connected_components(m).labels); },
            "(n,) the part of each vertex; vertices are connected through faces.")
        .def_property_readonly(
            "sizes", [](const SurfaceMesh& m) { return to_numpy(part_sizes(m)); },
            "(n,) the size of the part that each vertex is in, which lengths are shares of: four times the "
            "root "
            "mean\nsquare of the distance of its area from the centroid. Of most shapes, it is the diagonal "
            "of "
            "a box around\nthem to some per cent.")
        .def("is_made_of", &is_made_of, py::arg("points"), py::arg("faces"),
             R"(Whether the constructor was given the same points and faces. Cost: O(n).

points  (n, 3), to the last bit.
faces   as in the constructor.

Raises InvalidMesh for arrays of another shape.)")
        .def("diagnose", &diagnose, py::call_guard<py::gil_scoped_release>(),
             "What is unusual about the mesh -> Diagnosis. Cost: O(n log n).")
        .def(
            "crossing_faces",
            [](const SurfaceMesh& mesh) {
                std::vector<std::array<int, 2>> pairs;
                {
                    const py::gil_scoped_release unlocked;
                    const double unit = normal_unit(mesh.points());
                    pairs = crossing_faces(mesh, points_in_unit(view(mesh.points()), unit));
                }
                return edge_array(pairs);
            },
            R"((k, 2) pairs of faces that have more in common than the corners and edges that they share, ascending.

These are where the surface passes through itself, touches itself or is folded onto itself. The answer is exact. Faces
are taken as their `triangles`; those without area are left out. Cost: O(n log n), and a test for each pair of
triangles that overlap along x, of which a surface in one piece has n^1.5.)")
        .def("__repr__", [](const SurfaceMesh& m) {
            return "<SurfaceMesh: " + std::to_string(m.vertex_count()) + " vertices, " +
                   std::to_string(m.face_count()) + " faces>";
        });

    module.def(
        "diameter",
        [](const ArrayLike& object) {
            const FloatArray array = floats(object, "points");
            const PointsView view = points<InvalidConstraint>(array, "points");
            return view.rows() > 0 ? 2.0 * enclosing_ball(Points(view)).radius : 0.0;
        },
        py::arg("points"),
        R"(The diameter of the smallest ball that holds points, which the radius of compact Rbf is a share of.

points  (n, 3); 0 without any.

Raises InvalidConstraint for another shape, or a number that is not finite.)");
}

} // namespace sinew::bindings
