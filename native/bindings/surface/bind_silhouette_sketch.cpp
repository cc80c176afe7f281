// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/bindings/method_binding.h"
#include "native/bindings/options.h"
#include "native/core/errors.h"
#include "native/methods/surface/sketch/occlusion.h"
#include "native/methods/surface/sketch/silhouette_lines.h"
#include "native/methods/surface/sketch/silhouette_sketch.h"

#include <pybind11/stl.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

SketchView sketch_view(const ArrayLike& axes, const OptionalArray& eye)
{
    SketchView view;
    const FloatArray rows = floats(axes, "axes");
    if (rows.ndim() != 2 || rows.shape(0) != 3 || rows.shape(1) != 3)
        throw InvalidOption("axes: the shape must be (3, 3)");
    view.axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
    if (!eye.is_none()) {
        const FloatArray place = floats(eye, "eye");
        if (place.ndim() != 1 || place.shape(0) != 3)
            throw InvalidOption("eye: the shape must be (3,)");
        view.eye = Vector3(place.data()[0], place.data()[1], place.data()[2]);
    }
    view.check();
    return view;
}

std::vector<std::array<int, 2>> edge_pairs(const ArrayLike& object, const char* name)
{
    const py::array shape = py::array::ensure(object);
    if (!shape || shape.ndim() != 2 || shape.shape(1) != 2)
        throw InvalidConstraint(std::string(name) + ": the shape must be (k, 2)");
    const std::vector<int> flat = integers(object, name);
    std::vector<std::array<int, 2>> pairs(flat.size() / 2);
    for (std::size_t k = 0; k < pairs.size(); ++k)
        pairs[k] = {flat[2 * k], flat[2 * k + 1]};
    return pairs;
}

py::tuple line_arrays(const std::vector<LinePoint>& line)
{
    py::array_t<int> edges({static_cast<py::ssize_t>(line.size()), py::ssize_t{2}});
    py::array_t<double> shares(static_cast<py::ssize_t>(line.size()));
    for (std::size_t k = 0; k < line.size(); ++k) {
        edges.mutable_data()[2 * k] = line[k].a;
        edges.mutable_data()[2 * k + 1] = line[k].b;
        shares.mutable_data()[k] = line[k].share;
    }
    return py::make_tuple(edges, shares);
}

void bind_silhouette_sketch(py::module_& module)
{
    module.def(
        "silhouette_lines",
        [](const SurfaceMesh& mesh, const ArrayLike& axes, const OptionalArray& eye) {
            const SketchView view = sketch_view(axes, eye);
            std::vector<SurfaceLine> lines;
            {
                const py::gil_scoped_release unlocked;
                lines = silhouette_lines(mesh, view);
            }
            py::list found;
            for (const SurfaceLine& line : lines) {
                const py::tuple arrays = line_arrays(line.points);
                found.append(py::make_tuple(arrays[0], arrays[1], line.closed));
            }
            return found;
        },
        py::arg("mesh"), py::arg("axes"), py::arg("eye") = py::none(),
        R"(The silhouettes of a mesh in a view, and its borders -> [(edges (k, 2), shares (k,), closed), ...].

Point i of a line is (1 - shares[i]) points[edges[i, 0]] + shares[i] points[edges[i, 1]]. There the interpolated normal is
at right angles to the line of sight. Hidden silhouettes are among them.

axes  (3, 3) rows to the right, up, and toward the viewer, orthonormal.
eye   (3,) the viewer of a perspective view; None for an orthographic one.

Costs O(n log n). Raises InvalidOption for another shape, or axes that are not orthonormal.)");
    module.def(
        "fit_stroke",
        [](const SurfaceMesh& mesh, const ArrayLike& stroke, const ArrayLike& axes, const OptionalArray& eye,
           const OptionalArray& edges, double nearness, bool hidden) -> py::object {
            const SketchView view = sketch_view(axes, eye);
            const FloatArray drawn = floats(stroke, "stroke");
            const PointsView places = points<InvalidConstraint>(drawn, "stroke");
            std::vector<std::array<int, 2>> chosen;
            if (!edges.is_none())
                chosen = edge_pairs(edges, "edges");
            const bool has_edges = !edges.is_none();
            std::optional<StrokeFit> fit;
            {
                const py::gil_scoped_release unlocked;
                if (has_edges) {
                    fit = fit_stroke(mesh, edge_lines(mesh, chosen, view), view, places, nearness);
                } else {
                    std::optional<Occlusion> occlusion; // made when a line is near enough
                    std::function<bool(const LinePoint&)> hides;
                    if (!hidden)
                        hides = [&](const LinePoint& point) {
                            if (!occlusion)
                                occlusion.emplace(mesh, view);
                            return occlusion->hides(point);
                        };
                    fit = fit_stroke(mesh, silhouette_lines(mesh, view), view, places, nearness, hides);
                }
            }
            if (!fit)
                return py::none();
            const py::tuple arrays = line_arrays(fit->points);
            return py::make_tuple(arrays[0], arrays[1], to_numpy(std::move(fit->targets)));
        },
        py::arg("mesh"), py::arg("stroke"), py::arg("axes"), py::arg("eye") = py::none(),
        py::arg("edges") = py::none(), py::arg("nearness") = 0.5, py::arg("hidden") = false,
        R"(The part of a silhouette that a stroke redraws -> (edges (k, 2), shares (k,), targets (k, 3)), or None.

The points of the part and the stroke are matched by the shares of their arc lengths on the screen. The targets have the
depths of the points.

stroke    (s, 3) points of which only where they are seen counts.
axes, eye as for silhouette_lines().
edges     (e, 2) vertices of the edges of a line to take instead of the silhouettes.
nearness  how far the ends of the stroke may be from the line, as a share of its length. Beyond, the answer is None.
hidden    whether silhouettes count that are hidden behind the mesh. Chosen edges always do.

Costs O(n log n). Raises InvalidConstraint for a stroke of fewer than two points, without a length, behind the viewer, or
with a number that is not finite, and for an edge without its vertices; InvalidOption.)");

    py::class_<SilhouetteSketch>(
        module, "SilhouetteSketch",
        R"(Laplacian editing of a surface on which a line is drawn anew [Nealen et al. 2005], tutorial section 4.5.2.

The points of the line go to their targets, and the surface around keeps its details, which turn with it.)")
        .def(py::init([](const SurfaceMesh& mesh, const OptionalArray& edges, const ArrayLike& shares,
                         const ArrayLike& held, const Chosen<Discretization>& laplacian, int refits,
                         double sharpness, double weight) {
                 const std::vector<std::array<int, 2>> pairs = edge_pairs(edges, "edges");
                 const FloatArray along = floats(shares, "shares");
                 if (along.ndim() != 1 || along.shape(0) != static_cast<py::ssize_t>(pairs.size()))
                     throw InvalidConstraint("shares: one number per edge is needed");
                 std::vector<LinePoint> line;
                 for (std::size_t k = 0; k < pairs.size(); ++k)
                     line.push_back({pairs[k][0], pairs[k][1], along.data()[k]});
                 const std::vector<int> stay = integers(held, "held");
                 const SilhouetteSketchOptions options{.laplacian = laplacian.value("laplacian"),
                                                       .refits = refits,
                                                       .sharpness = sharpness,
                                                       .weight = weight};
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<SilhouetteSketch>(mesh, std::move(line), stay, options);
             }),
             py::arg("mesh"), py::arg("edges"), py::arg("shares"), py::arg("held"), py::kw_only(),
             py::arg("laplacian") = "cotan_voronoi", py::arg("refits") = 2, py::arg("sharpness") = 0.0,
             py::arg("weight") = 0.99, R"(
mesh       SurfaceMesh, the rest shape.
edges      (k, 2) and shares (k,), the points of the line as fit_stroke() gives them.
held       (h,) vertices that stay.
laplacian  'uniform', 'cotan', 'cotan_voronoi' or 'robust'.
refits     how often the turns of the details are estimated, each time by one more solve.
sharpness  the curvature that is added along the line, as a multiple of its own: 0 none, 1 twice as much.
weight     0..1, less than 1: how firmly the points are drawn to their targets.

Costs one factorisation of the free vertices. Raises InvalidConstraint for a vertex that is not there, a share outside
0..1, or a line that is held as a whole; InvalidOption; FactorizationFailed.)")
        .def(
            "solve",
            [](const SilhouetteSketch& sketch, const ArrayLike& targets) {
                const FloatArray wanted = floats(targets, "targets");
                const PointsView given = points<InvalidConstraint>(wanted, "targets");
                Points positions;
                {
                    const py::gil_scoped_release unlocked;
                    sketch.solve(given, positions);
                }
                return to_numpy(std::move(positions));
            },
            py::arg("targets"), R"(The surface for targets (k, 3) of the points of the line -> (n, 3).

No factorisation; 1 + refits solves; safe from several threads. Raises InvalidConstraint for a wrong shape or a non-finite
number.)")
        .def("__repr__", [](const SilhouetteSketch& sketch) {
            return "<SilhouetteSketch: " + std::to_string(sketch.vertex_count()) + " vertices, " +
                   std::to_string(sketch.free_count()) + " free>";
        });
}

const MethodBinding silhouette_sketch_binding(&bind_silhouette_sketch);

} // namespace

} // namespace sinew::bindings
