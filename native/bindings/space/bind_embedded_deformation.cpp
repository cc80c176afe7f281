// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/handle_methods.h"
#include "native/methods/space/nonlinear/embedded_deformation.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace sinew::bindings {

namespace {

EmbeddedDeformation::Graph graph_of(const EmbeddedDeformation& method)
{
    const py::gil_scoped_release unlocked;
    return method.graph();
}

py::dict graph_as_dict(const EmbeddedDeformation& method)
{
    EmbeddedDeformation::Graph graph = graph_of(method);
    py::dict result;
    result["nodes"] = to_numpy(std::move(graph.nodes));
    result["edges"] = pairs(graph.edges);
    result["edge_length"] = graph.edge_length;
    result["pulls"] = to_numpy(std::move(graph.pulls));
    result["pull_handles"] = to_numpy(graph.pull_handles);
    result["strengths"] = to_numpy(graph.strengths);
    result["pull_weights"] = graph.pull_weights;
    return result;
}

RowMatrix embedded_weights(const EmbeddedDeformation& method)
{
    const py::gil_scoped_release unlocked;
    return method.weights();
}

py::tuple embedded_answer(const EmbeddedDeformation& method, const ArrayLike& given, bool from_rotations,
                          double tolerance, int max_iterations)
{
    const Poses maps = poses(given);
    EmbeddedDeformation::Answer answer;
    {
        const py::gil_scoped_release unlocked;
        answer = method.answer(maps,
                               from_rotations ? EmbeddedDeformation::Start::handles
                                              : EmbeddedDeformation::Start::no_rotations,
                               tolerance, max_iterations);
    }
    return py::make_tuple(to_numpy(std::move(answer.unknowns)), answer.report);
}

void bind_embedded_deformation(py::module_& module)
{
    bind_handle_method<EmbeddedDeformation, EmbeddedDeformationOptions>(
        module, "EmbeddedDeformation", R"(Embedded deformation [Sumner, Schmid & Pauly 2007], section 7.

A graph of nodes on the shape, each with an affine map that is nearly a rotation, moves any points near it. Nodes
and points are measured along the surface, where there is one, so limbs side by side stay apart. An incoming shape
takes the graph along.)")
        .def("graph", &graph_as_dict,
             R"(The graph of the last bind -> dict.

nodes         (m, 3) at rest.
edges         (e, 2) pairs of nodes that are to agree.
edge_length   their mean length, in which the energy measures.
pulls         (p, 3) the points that handles pull; for a handle of one or two points, also some beside them.
pull_handles  (p,) which handle.
strengths     (p,) how strongly.
pull_weights  (p, m) which nodes they follow.

Raises InvalidConstraint before bind().)")
        .def("weights", &embedded_weights,
             "(n, m + k) which nodes and handles each bound point follows; rows sum to 1.")
        .def(
            "answer", &embedded_answer, py::arg("poses"), py::kw_only(), py::arg("from_rotations") = true,
            py::arg("tolerance") = 1e-4, py::arg("max_iterations") = 40,
            R"(The maps of the nodes -> (4 m, 3), SolveReport. Four rows per node: the columns of its matrix, and where it is.

poses           (k, 3, 4)
from_rotations  start from rotations that are blended between the handles; if not, from none.

Raises InvalidConstraint as warp_poses().)");
}

const MethodBinding embedded_deformation_binding(&bind_embedded_deformation);

} // namespace

} // namespace sinew::bindings
