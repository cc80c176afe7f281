// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/bindings/representation.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>

namespace sinew::bindings {

namespace {

VectorX influence(const CageCoordinates& coordinates, std::vector<int> vertices)
{
    std::ranges::sort(vertices);
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const int count = coordinates.cage().control_count();
    const py::gil_scoped_release unlocked;
    const AccessLock shared = coordinates.reading();
    for (int vertex : vertices)
        if (vertex < 0 || vertex >= count)
            throw InvalidConstraint("vertices: the cage has no vertex " + std::to_string(vertex),
                                    Error::Element::vertex, {vertex});
    return coordinates.weights().sum(vertices);
}

RowMatrix vertex_weights(const CageCoordinates& coordinates)
{
    const py::gil_scoped_release unlocked;
    const AccessLock shared = coordinates.reading();
    const RowMatrix dense = coordinates.weights().dense();
    return dense.leftCols(std::min<Eigen::Index>(coordinates.cage().control_count(), dense.cols()));
}

const std::shared_ptr<const SmoothCage>& smooth_of(const CageCoordinates& coordinates)
{
    return coordinates.cage().smooth();
}

} // namespace

void bind_cage(py::module_& module)
{
    py::class_<CageCoordinates, SpaceMethod, std::shared_ptr<CageCoordinates>>(
        module, "CageCoordinates", "What every cage method can do.")
        .def("influence", &influence, py::arg("vertices"),
             R"(How strongly some vertices of the cage move each point -> (n,) the sums of their weights.

vertices  indices; one that comes twice counts once. Cost: O(points x vertices), or O(weights) if they are
          sparse.

Raises InvalidConstraint for an index that the cage does not have.)")
        .def_property_readonly("vertex_weights", &vertex_weights, "(n, c) weights of the cage's vertices.")
        .def_property_readonly(
            "smooth_level",
            [](const CageCoordinates& self) { return smooth_of(self) ? smooth_of(self)->level() : 0; },
            "How often a smooth cage is refined; 0 for other cages.")
        .def_property_readonly(
            "smooth_mesh", [](const CageCoordinates& self) { return self.cage().smooth_mesh(); },
            "SurfaceMesh, the smooth surface at rest, in the frame of the cage; None for other cages.")
        .def(
            "smooth_error",
            [](const CageCoordinates& self) {
                return smooth_of(self) ? smooth_of(self)->error() * self.cage().frame().unit() : 0.0;
            },
            py::call_guard<py::gil_scoped_release>(), R"(
How far the faces of smooth_mesh, as bilinear patches, are from the limit surface -> a length: 4/3 of the largest
distance of their middles and sides from those of the next level; it falls by a factor of four per level. 0 for
other cages. Cost: some us per vertex of that level.)")
        .def("__repr__", [](const py::object& self) {
            const int count = self.cast<const CageCoordinates&>().cage().control_count();
            return representation(self, "a cage of " + std::to_string(count) + " vertices");
        });
}

} // namespace sinew::bindings
