// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/creases.h"
#include "native/bindings/options.h"
#include "native/subdivision/subdivision_surface.h"

#include <pybind11/eigen.h>

namespace sinew::bindings {

namespace {

SubdivisionSurface make_surface(const SurfaceMesh& mesh, const Chosen<SubdivisionScheme>& scheme, int level,
                                bool limit, const OptionalArray& creases, const OptionalArray& corners,
                                const Chosen<BoundarySmooth>& boundary_smooth,
                                const Chosen<UvSmooth>& uv_smooth, const OptionalArray& face_varying)
{
    SubdivisionOptions options;
    options.scheme = scheme.value("scheme");
    options.level = level;
    options.limit = limit;
    options.boundary_smooth = boundary_smooth.value("boundary_smooth");
    options.uv_smooth = uv_smooth.value("uv_smooth");
    read_creases(creases, corners, options);
    if (!face_varying.is_none())
        options.face_varying = integers(face_varying, "face_varying");
    const py::gil_scoped_release unlocked;
    return SubdivisionSurface(mesh, options);
}

void check_shape(const py::array& array, int rows, const char* name)
{
    if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != 3)
        throw InvalidConstraint(std::string(name) + ": the shape must be (" + std::to_string(rows) + ", 3)");
}

/// Into `out` where it is given, so that a frame needs no new memory.
template <class T>
py::array refine(const SubdivisionSurface& surface, const py::array_t<T, py::array::c_style>& points,
                 const Out& out)
{
    check_shape(points, surface.control_count(), "points");
    py::array_t<T> refined;
    if (out.is_none()) {
        refined = py::array_t<T>({static_cast<py::ssize_t>(surface.vertex_count()), py::ssize_t{3}});
    } else {
        if (!py::isinstance<py::array_t<T, py::array::c_style>>(out))
            throw py::type_error("out: a C-contiguous array of the type of the points is needed");
        refined = out.cast<py::array_t<T, py::array::c_style>>();
        check_shape(refined, surface.vertex_count(), "out");
    }
    T* const to = refined.mutable_data(); // refuses a read-only array
    {
        const py::gil_scoped_release unlocked;
        surface.refine(points.data(), to);
    }
    return refined;
}

/// (m, k) if all faces have k corners, otherwise (counts, indices).
py::object face_array(const std::vector<int>& counts, const std::vector<int>& corners)
{
    const auto faces = static_cast<py::ssize_t>(counts.size());
    const int size = counts.empty() ? 4 : counts.front();
    if (static_cast<std::size_t>(faces) * size == corners.size() &&
        std::all_of(counts.begin(), counts.end(), [size](int count) { return count == size; }))
        return py::array_t<int>({faces, static_cast<py::ssize_t>(size)}, corners.data());
    return py::make_tuple(to_numpy(counts), to_numpy(corners));
}

} // namespace

void bind_subdivision(py::module_& module)
{
    py::class_<SubdivisionSurface>(module, "SubdivisionSurface", R"(A mesh refined by OpenSubdiv.

Catmull & Clark 1978, Loop 1987, with the creases of DeRose, Kass & Truong 1998. The surface is that of Blender's
Subdivision modifier. The first vertices are those of the mesh, then come those that each level adds.)")
        .def(py::init(&make_surface), py::arg("mesh"), py::kw_only(), py::arg("scheme") = "catmull_clark",
             py::arg("level") = 2, py::arg("limit") = false, py::arg("creases") = py::none(),
             py::arg("corners") = py::none(), py::arg("boundary_smooth") = "all",
             py::arg("uv_smooth") = "preserve_boundaries", py::arg("face_varying") = py::none(), R"(
scheme           'catmull_clark', 'loop' (only triangles) or 'bilinear'.
level            how many times faces are split, 0 to 10.
limit            whether to move the vertices to the limit of endless subdivision (Blender: Use Limit Surface).
creases          (edges (k, 2), sharpness (k,) or one number): sharp for so many levels; from 10 on, for all levels.
                 A crease c of Blender, in [0, 1], is the sharpness 10 c^2.
corners          (vertices (k,), sharpness (k,) or one number).
boundary_smooth  'all' or 'preserve_corners'.
uv_smooth        'none', 'preserve_corners', 'preserve_corners_and_junctions',
                 'preserve_corners_junctions_and_concave', 'preserve_boundaries' or 'smooth_all'.
face_varying     (corners,) index of a value, for example a UV, at each face corner; None for no such channel.

Cost: about 1 us per refined vertex. Raises InvalidMesh for faces that the scheme cannot take, InvalidOption for
edges that the mesh does not have, OutOfMemory above limit_memory().)")
        .def(
            "refine",
            [](const SubdivisionSurface& surface, const ArrayLike& object, const Out& out) {
                using Single = py::array_t<float, py::array::c_style>;
                if (py::isinstance<Single>(object))
                    return refine<float>(surface, object.cast<Single>(), out);
                return refine<double>(surface, floats(object, "points"), out);
            },
            py::arg("points"), py::arg("out") = py::none(), R"(
(n, 3) control points -> (m, 3) refined points, float32 for float32, otherwise float64; written into `out` if that
is given. Cost: one pass over the weights.

Raises InvalidConstraint for another shape.)")
        .def(
            "reordered",
            [](const SubdivisionSurface& surface, const ArrayLike& order) {
                const std::vector<int> wanted = integers(order, "order");
                const py::gil_scoped_release unlocked;
                return surface.reordered(wanted);
            },
            py::arg("order"), R"(
(m,) -> the same surface, whose vertex k is what was vertex order[k]. Refining costs as much as before.

Raises InvalidOption where the order does not name each vertex once.)")
        .def_property_readonly("matrix", &SubdivisionSurface::matrix,
                               "(m, n) SciPy CSR; refined points are this times the control points.")
        .def_property_readonly(
            "faces",
            [](const SubdivisionSurface& s) { return face_array(s.face_counts(), s.face_corners()); },
            "(f, 4) refined faces, (f, 3) with loop; at level 0, (counts, indices) if faces have different "
            "sizes.")
        .def(
            "normals",
            [](const SubdivisionSurface& surface, const ArrayLike& object) {
                const FloatArray array = floats(object, "refined");
                check_shape(array, surface.vertex_count(), "refined");
                const PointsView refined(array.data(), array.shape(0), 3);
                Points normals;
                {
                    const py::gil_scoped_release unlocked;
                    normals = surface.normals(refined);
                }
                return to_numpy(std::move(normals));
            },
            py::arg("refined"),
            "(m, 3) refined points -> (m, 3) unit normals, means over the faces around each point by area.\n"
            "Raises InvalidConstraint for another shape.")
        .def(
            "refine_face_varying",
            [](const SubdivisionSurface& surface, const ArrayLike& object) {
                const FloatArray values = floats(object, "values");
                const SparseRows& matrix = surface.face_varying_matrix();
                if (values.ndim() != 2 || values.shape(0) != matrix.cols())
                    throw InvalidConstraint("values: the shape must be (" + std::to_string(matrix.cols()) +
                                            ", d)");
                using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
                const Eigen::Map<const Rows> from(values.data(), values.shape(0), values.shape(1));
                return Rows(matrix * from);
            },
            py::arg("values"),
            "(q, d) values of the channel -> (p, d) refined values. Raises InvalidConstraint for another "
            "shape.")
        .def_property_readonly("face_varying_matrix", &SubdivisionSurface::face_varying_matrix,
                               "(p, q) SciPy CSR; refined values are this times the values, both (., d).")
        .def_property_readonly(
            "face_varying_corners",
            [](const SubdivisionSurface& s) { return to_numpy(s.face_varying_corners()); },
            "(c,) the index of the refined value at each refined face corner.")
        .def_property_readonly("vertex_count", &SubdivisionSurface::vertex_count, "Refined vertices, m.")
        .def_property_readonly("control_count", &SubdivisionSurface::control_count, "Control vertices, n.")
        .def("__repr__", [](const SubdivisionSurface& s) {
            return "<SubdivisionSurface: " + std::to_string(s.control_count()) + " vertices -> " +
                   std::to_string(s.vertex_count()) + ">";
        });
}

} // namespace sinew::bindings
