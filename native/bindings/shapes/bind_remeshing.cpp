// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/mesh/remeshing/decimation.h"
#include "native/mesh/remeshing/degenerate_removal.h"
#include "native/mesh/remeshing/isotropic_remeshing.h"
#include "native/mesh/remeshing/semi_regular.h"
#include "native/operators/lengths_by_curvature.h"

#include <optional>
#include <string>

namespace sinew::bindings {

namespace {

template <class T>
py::array_t<T> table(const T* first, std::size_t rows, py::ssize_t columns)
{
    return py::array_t<T>({static_cast<py::ssize_t>(rows), columns}, rows == 0 ? nullptr : first);
}

template <class T>
py::array_t<T> corner_table(const T* first, std::size_t corners)
{
    return py::array_t<T>({static_cast<py::ssize_t>(corners / 3), py::ssize_t{3}, py::ssize_t{3}},
                          corners == 0 ? nullptr : first);
}

template <class T>
auto first_of(const std::vector<T>& rows)
{
    return rows.empty() ? nullptr : rows.front().data();
}

std::vector<Edge> given_lines(const OptionalArray& lines)
{
    return lines.is_none() ? std::vector<Edge>{} : index_pairs(lines, "lines");
}

Remeshed made_fewer(const SurfaceMesh& mesh, int faces, double angle, const OptionalArray& lines,
                    const Callback& progress)
{
    const std::vector<Edge> given = given_lines(lines);
    const Progress ticks = bindings::progress(progress);
    const py::gil_scoped_release unlocked;
    return decimate(mesh, {.faces = faces, .angle = angle}, given, ticks);
}

Remeshed made_clean(const SurfaceMesh& mesh, double ratio, double cap, double share, double angle,
                    const OptionalArray& lines, const Callback& progress)
{
    const std::vector<Edge> given = given_lines(lines);
    const Progress ticks = bindings::progress(progress);
    const py::gil_scoped_release unlocked;
    return remove_degenerate(mesh, {.ratio = ratio, .cap = cap, .share = share, .angle = angle}, given,
                             ticks);
}

SemiRegular made_regular(const SurfaceMesh& mesh, int levels, const std::optional<int>& base_faces,
                         double angle, const OptionalArray& lines, const Callback& progress)
{
    const std::vector<Edge> given = given_lines(lines);
    if (base_faces && *base_faces < 4)
        throw InvalidOption("base_faces must be at least 4");
    const Progress ticks = bindings::progress(progress);
    const py::gil_scoped_release unlocked;
    return semi_regular(mesh, {.levels = levels, .base_faces = base_faces.value_or(0), .angle = angle}, given,
                        ticks);
}

Remeshed made_even(const SurfaceMesh& mesh, const OptionalArray& length, int rounds, double angle,
                   const OptionalArray& lines, const Callback& progress)
{
    const std::vector<Edge> given = given_lines(lines);
    const std::vector<double> lengths = length.is_none() ? std::vector<double>{} : numbers(length, "length");
    if (!length.is_none() && lengths.empty())
        throw InvalidOption("length: there are none");
    const Progress ticks = bindings::progress(progress);
    const py::gil_scoped_release unlocked;
    return remesh(mesh, {.lengths = lengths, .rounds = rounds, .angle = angle}, given, ticks);
}

void bind_remeshing(py::module_& module)
{
    py::class_<Remeshed>(module, "Remeshed",
                         R"(New triangles for a surface, and where they lie on the old one.

What the old surface carries is carried over by this: of vertices, `(values[r.vertex_sources] *
r.vertex_weights[..., None]).sum(1)`; of corners, the same with `corner_sources` and `corner_weights`; of faces,
`values[r.face_sources]`.)")
        .def_property_readonly(
            "points", [](const Remeshed& r) { return table(first_of(r.points), r.points.size(), 3); },
            "(n, 3) vertices.")
        .def_property_readonly(
            "faces", [](const Remeshed& r) { return table(first_of(r.triangles), r.triangles.size(), 3); },
            "(m, 3) triangles.")
        .def_property_readonly(
            "lines", [](const Remeshed& r) { return table(first_of(r.lines), r.lines.size(), 2); },
            "(k, 2) edges that lie on given lines.")
        .def_property_readonly(
            "line_sources", [](const Remeshed& r) { return to_numpy(r.sources); },
            "(k,) which of the given lines.")
        .def_property_readonly(
            "vertex_sources",
            [](const Remeshed& r) {
                return table(first_of(r.origins.vertices), r.origins.vertices.size(), 3);
            },
            "(n, 3) the corners of the old triangle in which the closest point lies.")
        .def_property_readonly(
            "vertex_weights",
            [](const Remeshed& r) {
                return table(first_of(r.origins.vertex_weights), r.origins.vertex_weights.size(), 3);
            },
            "(n, 3) the barycentric coordinates there, from 0 to 1.")
        .def_property_readonly(
            "face_sources", [](const Remeshed& r) { return to_numpy(r.origins.faces); },
            "(m,) the old face that is closest to the centroid.")
        .def_property_readonly(
            "corner_sources",
            [](const Remeshed& r) {
                return corner_table(first_of(r.origins.corners), r.origins.corners.size());
            },
            "(m, 3, 3) for each corner three old corners, counted face after face. The corners of a face lie "
            "on one\nside of the given lines.")
        .def_property_readonly(
            "corner_weights",
            [](const Remeshed& r) {
                return corner_table(first_of(r.origins.corner_weights), r.origins.corner_weights.size());
            },
            "(m, 3, 3) their barycentric coordinates.")
        .def_property_readonly(
            "distance", [](const Remeshed& r) { return r.origins.farthest; },
            "The largest distance of a vertex or centroid of one surface from the other one.")
        .def_property_readonly(
            "mean_distance", [](const Remeshed& r) { return r.origins.mean; },
            "The mean distance of the new vertices from the old surface.")
        .def_readonly("length", &Remeshed::length,
                      "The one length that edges were to have; 0 where there was none.")
        .def("__repr__", [](const Remeshed& r) {
            return "<Remeshed: " + std::to_string(r.points.size()) + " vertices, " +
                   std::to_string(r.triangles.size()) + " faces, distance " +
                   std::to_string(r.origins.farthest) + ">";
        });

    module.def("remesh", &made_even, py::arg("mesh"), py::arg("length") = py::none(), py::kw_only(),
               py::arg("rounds") = 3, py::arg("angle") = RemeshOptions{}.angle, py::arg("lines") = py::none(),
               py::arg("progress") = py::none(), R"(
New triangles of even size and shape on the same surface -> Remeshed [Botsch & Kobbelt 2004].

Borders, given lines and sharp folds are kept, with the places where they end, meet or bend sharply; edges along them
are only split and joined. A mesh that is no manifold is cut where it is none, and joined again. Vertices without faces
are left out.

mesh      SurfaceMesh.
length    that edges should have, more than 0, or (n,) for each vertex, as lengths_by_curvature() returns; None: the
          mean length of the edges of its triangles.
rounds    >= 1; each splits long edges, collapses short ones, flips and relaxes.
angle     radians between the normals of faces, in (0, pi]; long folds that are sharper are kept.
lines     None or (k, 2) vertices of edges that are kept, such as seams; pairs without an edge are ignored.
progress  None or callable(fraction, stage); returning False cancels.

Cost: O(n log n) in each round; 86,000 triangles take some seconds. Raises InvalidMesh where no face has an area,
InvalidOption, also for a length that would give more than 20 million triangles or is far too short for needles, or
Cancelled.)");

    module.def(
        "lengths_by_curvature",
        [](const SurfaceMesh& mesh, double tolerance, double shortest, double longest, double angle) {
            return lengths_by_curvature(
                mesh, {.tolerance = tolerance, .shortest = shortest, .longest = longest, .angle = angle});
        },
        py::arg("mesh"), py::arg("tolerance") = 0.0, py::kw_only(), py::arg("shortest") = 0.0,
        py::arg("longest") = 0.0, py::arg("angle") = CurvatureLengthOptions{}.angle,
        py::call_guard<py::gil_scoped_release>(), R"(
How long edges may be at each vertex so that triangles stay close to the surface -> (n,) for remesh() [Dunyach et al.
2013].

Lengths are short where the surface, a border or a fold bends, and rise from there by at most half of the way along an
edge. Vertices without faces get the longest one.

mesh       SurfaceMesh, fine enough to show how it bends.
tolerance  how far triangles may be from it, >= 0; 0: a thousandth of the diagonal of its box.
shortest   >= 0; 0: twice the tolerance.
longest    >= 0; 0: a tenth of the diagonal.
angle      radians between the normals of faces, in (0, pi]; folds that are sharper do not count as bent.

Cost: O(n log n), about that of curvature(). Raises InvalidMesh where no face has an area, or InvalidOption.)");

    module.def("decimate", &made_fewer, py::arg("mesh"), py::arg("faces"), py::kw_only(),
               py::arg("angle") = DecimateOptions{}.angle, py::arg("lines") = py::none(),
               py::arg("progress") = py::none(), R"(
Fewer triangles for the same surface -> Remeshed [Lindstrom & Turk 1998].

The edge whose collapse changes the shape least is collapsed, until so many triangles are left, or none can be
collapsed without turning a triangle over. Lines are kept as by remesh(): edges along them are collapsed onto them.

mesh      SurfaceMesh.
faces     triangles wanted, >= 4.
angle     radians between the normals of faces, in (0, pi]; long folds that are sharper are kept.
lines     None or (k, 2) vertices of edges that are kept, such as seams; pairs without an edge are ignored.
progress  None or callable(fraction, stage); returning False cancels.

Cost: O(n log n). Raises InvalidMesh where no face has an area, InvalidOption or Cancelled.)");

    module.def("remove_degenerate", &made_clean, py::arg("mesh"), py::kw_only(),
               py::arg("ratio") = DegenerateOptions{}.ratio, py::arg("cap") = DegenerateOptions{}.cap,
               py::arg("share") = DegenerateOptions{}.share, py::arg("angle") = DegenerateOptions{}.angle,
               py::arg("lines") = py::none(), py::arg("progress") = py::none(), R"(
The triangles without needles, which have a very short side, and caps, which have a very wide angle -> Remeshed
[Botsch & Kobbelt 2001].

Short sides of needles are collapsed, long sides of caps are flipped. Borders, given lines and sharp folds stay, with
the needles between them.

mesh      SurfaceMesh.
ratio     > 1; of the longest side to the shortest one: triangles above it are needles.
cap       radians, in (pi / 2, pi]: triangles with a wider angle are caps.
share     > 0; needles go whose shortest side is below this share of the mean edge.
angle     radians between the normals of faces, in (0, pi]; long folds that are sharper are kept.
lines     None or (k, 2) vertices of edges that are kept, such as seams; pairs without an edge are ignored.
progress  None or callable(fraction, stage); returning False cancels, before or after the triangles are removed.

Cost: O(n log n). Raises InvalidMesh where no face has an area, InvalidOption or Cancelled.)");

    py::class_<SemiRegular>(module, "SemiRegular",
                            "A surface as a base of few triangles, each split into four several times.")
        .def_readonly("finest", &SemiRegular::finest,
                      "The last level, a Remeshed. The vertices of each level are its first ones.")
        .def_property_readonly(
            "base_faces", [](const SemiRegular& s) { return table(first_of(s.base), s.base.size(), 3); },
            "(b, 3) triangles of the base.")
        .def_property_readonly(
            "counts", [](const SemiRegular& s) { return to_numpy(s.counts); },
            "(l,) vertices of the base and of each level.")
        .def_property_readonly(
            "displacements",
            [](const SemiRegular& s) {
                py::list levels;
                for (const auto& moves : s.displacements)
                    levels.append(table(first_of(moves), moves.size(), 3));
                return levels;
            },
            "List of (k, 3) for each level: how far its new vertices lie from the middle of the edge that "
            "they split.")
        .def("__repr__", [](const SemiRegular& s) {
            return "<SemiRegular: " + std::to_string(s.base.size()) + " faces, " +
                   std::to_string(s.displacements.size()) + " levels, distance " +
                   std::to_string(s.finest.origins.farthest) + ">";
        });

    module.def("semi_regular", &made_regular, py::arg("mesh"),
               py::arg("levels") = SemiRegularOptions{}.levels, py::kw_only(),
               py::arg("base_faces") = py::none(), py::arg("angle") = SemiRegularOptions{}.angle,
               py::arg("lines") = py::none(), py::arg("progress") = py::none(), R"(
Fit a subdivided base of few triangles to a surface -> SemiRegular [Eck et al. 1995, Guskov et al. 2000].

The base comes from decimate(). Each level splits the edges in the middle and puts the new vertices onto the surface, or
onto the kept lines. Where the base is too coarse for the shape, triangles may fold.

mesh        SurfaceMesh.
levels      1 to 10.
base_faces  triangles of the base, >= 4; None: so many that the last level has as many as the mesh, but at least 500, or
            a quarter of those of the mesh.
angle       radians between the normals of faces, in (0, pi]; long folds that are sharper are kept.
lines       None or (k, 2) vertices of edges that are kept, such as seams; pairs without an edge are ignored.
progress    None or callable(fraction, stage); returning False cancels.

Cost: O(n log n). Raises InvalidMesh where no face has an area, InvalidOption, also for more than 20 million triangles,
or Cancelled.)");
}

const MethodBinding remeshing_binding(&bind_remeshing);

} // namespace

} // namespace sinew::bindings
