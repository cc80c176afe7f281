// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/read_write_lock.h"
#include "native/core/report.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/space/weights/points_outside.h"
#include "native/solvers/systems/not_converged.h"

#include <pybind11/stl.h>

#include <map>
#include <typeindex>

namespace sinew::bindings {

namespace {

const char* name_of(Error::Element kind)
{
    switch (kind) {
    case Error::Element::vertex:
        return "vertex";
    case Error::Element::face:
        return "face";
    case Error::Element::handle:
        return "handle";
    case Error::Element::none:
        break;
    }
    return "";
}

/// Raises `type` with the message, `elements` and `element_kind` of a native error.
void raise(const py::handle& type, const Error& error)
{
    const py::object instance = type(error.what());
    instance.attr("elements") = py::cast(error.elements());
    instance.attr("element_kind") = name_of(error.element_kind());
    PyErr_SetObject(type.ptr(), instance.ptr());
}

/// The Python exception of each C++ error. The references are borrowed, as the module keeps the types alive.
std::map<std::type_index, PyObject*>& types()
{
    static std::map<std::type_index, PyObject*> map;
    return map;
}

template <class E>
void add(py::module_& module, const char* name, const char* doc, const py::handle& base)
{
    const std::string full = std::string("sinew_native.") + name;
    PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), doc, base.ptr(), nullptr);
    if (!type)
        throw py::error_already_set();
    module.add_object(name, py::reinterpret_steal<py::object>(type));
    types()[typeid(E)] = type;
}

} // namespace

void bind_core(py::module_& module)
{
    add<Error>(module, "Error",
               "Base class of all errors that the library raises. `elements` lists the indices at fault, and "
               "`element_kind` says what they count: 'vertex', 'face', 'handle' or ''.",
               PyExc_Exception);
    const py::object base = module.attr("Error");
    base.attr("elements") = py::list();
    base.attr("element_kind") = "";
    add<InvalidMesh>(
        module, "InvalidMesh",
        "Raised when a mesh has no vertices, a point that is not finite, or an index out of range.", base);
    add<InvalidConstraint>(
        module, "InvalidConstraint",
        "Raised when handles, weights, poses or incoming points do not fit the mesh or each other.", base);
    add<PointsOutside>(module, "PointsOutside",
                       "Raised when points lie outside the control, where the method cannot move them.",
                       module.attr("InvalidConstraint"));
    add<InvalidOption>(module, "InvalidOption", "Raised when an option is outside its documented range.",
                       base);
    add<FactorizationFailed>(
        module, "FactorizationFailed",
        "Raised when a system of equations has no unique solution, or when there is no memory for "
        "its factor.",
        base);
    add<OutOfMemory>(
        module, "OutOfMemory",
        "Raised when a bind needs more memory than limit_memory() allows, or than the machine has.",
        module.attr("FactorizationFailed"));
    add<NotConverged>(module, "NotConverged",
                      "Raised when an iteration uses up its steps, or moves away from the solution.", base);
    add<Cancelled>(
        module, "Cancelled",
        "Raised when the progress callback returned False. The object is as it was before the call.", base);
    add<ObjectInUse>(
        module, "ObjectInUse",
        "Raised when a progress callback binds an object that is in use, or uses one that is being "
        "bound: a callback cannot wait for the call that it belongs to.",
        base);

    py::register_exception_translator([](std::exception_ptr pointer) {
        try {
            if (pointer)
                std::rethrow_exception(pointer);
        } catch (const Error& error) {
            const auto found = types().find(typeid(error));
            raise(found != types().end() ? found->second : types().at(typeid(Error)), error);
        }
    });

    py::class_<Ride>(module, "Ride", "A connected part without a handle that rides on another part.")
        .def_readonly("part", &Ride::part, "Its number; parts are numbered by their lowest vertices.")
        .def_readonly("first_vertex", &Ride::first_vertex, "Its lowest vertex.")
        .def_readonly("vertex_count", &Ride::vertex_count, "Number of its vertices.")
        .def_readonly("host", &Ride::host, "The part that it rides on, which may ride itself.")
        .def_readonly("frame_count", &Ride::frame_count, "Number of its frames; 1 where it moves rigidly.")
        .def("__repr__", [](const Ride& r) {
            return "<Ride: part " + std::to_string(r.part) + " of " + std::to_string(r.vertex_count) +
                   " vertices on part " + std::to_string(r.host) + ", " + std::to_string(r.frame_count) +
                   (r.frame_count == 1 ? " frame>" : " frames>");
        });

    py::class_<BindReport>(module, "BindReport", "What set_handles() or rebind() did.")
        .def_property_readonly(
            "reuse", [](const BindReport& r) { return name_of(r.reuse); },
            "What rebind() took over: 'anew' for nothing, 'updated' for a part, 'kept' for everything.")
        .def_readonly("changed", &BindReport::changed,
                      "What differs from the object that rebind() was given.")
        .def_readonly("handle_count", &BindReport::handle_count,
                      "Number of handles, including fixed regions.")
        .def_readonly("constrained_vertices", &BindReport::constrained_vertices,
                      "Number of vertices that a handle holds exactly.")
        .def_readonly("soft_vertices", &BindReport::soft_vertices,
                      "Number of vertices that a handle pulls softly.")
        .def_readonly("free_parts", &BindReport::free_parts,
                      "Number of connected parts without any constraint that stay at rest.")
        .def_property_readonly(
            "free_vertices", [](const BindReport& r) { return to_numpy(r.free_vertices); },
            "(f,) the vertices of those parts.")
        .def_readonly("rides", &BindReport::rides,
                      "A Ride for each connected part without any constraint that follows another part.")
        .def_property_readonly(
            "riding_vertices", [](const BindReport& r) { return to_numpy(r.riding_vertices); },
            "(r,) the vertices of those parts.")
        .def_readonly("detail_vectors", &BindReport::detail_vectors,
                      "Number of details that are vectors, because 'normal_displacements' of Multiresolution "
                      "found no\nplace on the base for them.")
        .def_readonly("irregular_parts", &BindReport::irregular_parts,
                      "Number of parts with a handle that SubdivisionEditing found no subdivision in.")
        .def_property_readonly(
            "irregular_vertices", [](const BindReport& r) { return to_numpy(r.irregular_vertices); },
            "(i,) the vertices of those parts.")
        .def_property_readonly(
            "thin_vertices", [](const BindReport& r) { return to_numpy(r.thin_vertices); },
            "(t,) vertices at edges where the sheet of ThinShellNonlinear is thinner than the mesh can show.")
        .def_readonly("remarks", &BindReport::remarks,
                      "What the method cannot carry, and what is used instead; a list of texts.")
        .def_readonly("degenerate_faces", &BindReport::degenerate_faces,
                      "Number of faces with a triangle of (nearly) no area, whose area was raised.")
        .def_readonly("factorizations", &BindReport::factorizations,
                      "Numeric factorisations so far, including those taken over by rebind().")
        .def_readonly("analyses", &BindReport::analyses, "Symbolic factorisations so far, likewise.")
        .def_readonly(
            "refactored", &BindReport::refactored,
            "Share of the last numeric factorisation that had to be computed; below 1 if a bind kept\n"
            "the rest of the factor.")
        .def_readonly("factor_bytes", &BindReport::factor_bytes, "Memory of the factors.")
        .def_readonly("seconds", &BindReport::seconds, "Wall clock time of the call.")
        .def("__repr__", [](const BindReport& r) {
            return "<BindReport: " + std::to_string(r.handle_count) + " handles, " +
                   std::to_string(r.constrained_vertices) + " held, " + std::to_string(r.soft_vertices) +
                   " soft, " + std::to_string(r.free_parts) + " free parts, " +
                   std::to_string(r.rides.size()) + " riding>";
        });

    py::class_<SolveReport>(module, "SolveReport", "What solve() reached.")
        .def_readonly("iterations", &SolveReport::iterations, "Trial steps; 1 for a linear method.")
        .def_readonly("rejected", &SolveReport::rejected, "Trials that did not lower the energy.")
        .def_readonly("energy", &SolveReport::energy, "Of the returned shape, as the class defines it.")
        .def_readonly("residual", &SolveReport::residual,
                      "Linear: |A d - b| / |b|. Nonlinear: what was last compared with the tolerance.")
        .def_readonly("converged", &SolveReport::converged,
                      "The tolerance was met. If not, the iterations were used up, or no step lowers the "
                      "energy any more.")
        .def_readonly(
            "half_turns", &SolveReport::half_turns,
            "Number of vertices between handles that are turned against each other by half a turn,\n"
            "where a rule chose the way to turn.")
        .def_readonly(
            "fallbacks", &SolveReport::fallbacks,
            "How often a quick iteration stalled, so that a slow one took over: 'displacement_volumes' of\n"
            "Multiresolution in tight bends and on a base of another size.")
        .def_readonly("inverted_faces", &SolveReport::inverted_faces,
                      "Number of faces that the shape turns over against the prisms of Primo.")
        .def("__repr__", [](const SolveReport& r) {
            return "<SolveReport: " + std::to_string(r.iterations) + " iterations, energy " +
                   std::to_string(r.energy) + (r.converged ? ", converged>" : ", not converged>");
        });

    module.def("instructions", &widest_instructions,
               "The widest instructions of this processor that the library uses, for example 'AVX2'.");
    module.def("limit_threads", &limit_threads, py::arg("count"),
               "At most `count` threads in the library's own loops; 0 lifts the limit.");
    module.def("limit_memory", &limit_memory, py::arg("size"),
               "No factor and no weights may take more than `size` bytes; 0 lifts the limit. A bind that "
               "would take\n"
               "more raises OutOfMemory, which names both sizes, before it takes the memory.");
}

} // namespace sinew::bindings
