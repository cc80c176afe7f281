// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/method_binding.h"
#include "native/core/errors.h"
#include "native/methods/space/method.h"
#include "native/methods/surface/method.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace sinew::bindings {

namespace {

/// "ThinShell" -> "thin_shell", the id of a method.
std::string id_of(const py::handle& type)
{
    std::string id;
    for (const char letter : type.attr("__name__").cast<std::string>()) {
        if (std::isupper(static_cast<unsigned char>(letter)) && !id.empty())
            id += '_';
        id += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
    return id;
}

/// The class of this id among those derived from a type, from which `known` gets all ids.
py::object derived_from(const py::type& type, const std::string& id, std::string& known)
{
    py::object found = py::none();
    for (const py::handle derived : type.attr("__subclasses__")()) {
        if (py::list(derived.attr("__subclasses__")()).empty()) {
            known += (known.empty() ? "'" : ", '") + id_of(derived) + "'";
            if (id_of(derived) == id)
                found = py::reinterpret_borrow<py::object>(derived);
        } else if (const py::object inner = derived_from(py::type(py::reinterpret_borrow<py::object>(derived)), id, known);
                   !inner.is_none()) {
            found = inner;
        }
    }
    return found;
}

template <class Base>
py::object method_of(const std::string& id)
{
    std::string known;
    py::object found = derived_from(py::type::of<Base>(), id, known);
    if (found.is_none())
        throw InvalidOption("method: '" + id + "' is not one of " + known);
    return found;
}

py::object mesh_of(const py::object& points, const py::object& faces)
{
    return py::type::of<SurfaceMesh>()(points, faces);
}

py::object deform_once(const py::object& points, const py::object& faces, const py::object& handles,
                  const py::object& poses, const std::string& method, const py::kwargs& options)
{
    const py::object mesh = mesh_of(points, faces);
    if (options.contains("base")) // of Multiresolution, by its id
        options["base"] = method_of<SurfaceMethod>(options["base"].cast<std::string>())(mesh);
    const py::object made = method_of<SurfaceMethod>(method)(mesh, **options);
    made.attr("set_handles")(handles);
    return made.attr("solve")(poses).cast<py::tuple>()[0];
}

py::object warp_once(const py::object& points, const py::object& cage, const py::object& posed_cage,
                const std::string& method, const py::kwargs& options)
{
    const py::object type = method_of<SpaceMethod>(method);
    py::object control = cage;
    if (py::isinstance<py::tuple>(cage)) {
        const auto parts = cage.cast<py::tuple>();
        if (parts.size() != 2)
            throw InvalidConstraint("cage: give (points, faces), or control points");
        control = mesh_of(parts[0], parts[1]);
    }
    const py::object made = type(control, **options);
    made.attr("bind")(points);
    return made.attr("warp")(posed_cage);
}

} // namespace

void bind_one_call(py::module_& module)
{
    module.def("deform", &deform_once, py::arg("points"), py::arg("faces"), py::arg("handles"), py::arg("poses"),
               py::arg("method") = "arap",
               R"(Deform a mesh once by handles on it -> (n, 3) positions.

points   (n, 3) rest positions.
faces    as SurfaceMesh takes them: (m, 3) or (m, 4) indices, or a tuple (counts, indices).
handles  sequence of vertex index arrays, one per handle; a region that stays is a handle, too.
poses    (k, 3, 4) affine map of each handle from its rest to its posed state, in the frame of the points.
method   the id of a method on a surface, such as 'thin_shell', 'arap' or 'primo'.
options  those of the method's class. Multiresolution takes the id of another method as `base`.

    points, faces = np.array([(x, y, 0.0) for y in range(3) for x in range(3)]), [(0, 1, 4, 3), (1, 2, 5, 4),
                                                                               (3, 4, 7, 6), (4, 5, 8, 7)]
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, 2, 3] = 1.0  # lifts the last row
    positions = sn.deform(points, faces, [[0, 1, 2], [6, 7, 8]], poses, method="arap", smoothness=0.5)

Each call binds and solves. For several poses make an object of the class, which binds once.

Raises what the class, set_handles() and solve() raise, and InvalidOption for an unknown method.)");
    module.def("warp", &warp_once, py::arg("points"), py::arg("cage"), py::arg("posed_cage"),
               py::arg("method") = "green",
               R"(Warp points once by a cage or by control points -> (n, 3) positions.

points      (n, 3) rest positions, inside the cage.
cage        (points (c, 3), faces) of a closed cage, or for methods without faces, such as 'rbf', control points (c, 3).
posed_cage  (c, 3) where its points are moved.
method      the id of a method of space, such as 'green', 'mean_value', 'harmonic' or 'rbf'.
options     those of the method's class.

    corners = np.array([(x, y, z) for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    positions = sn.warp([(0.0, 0.0, 0.5)], (corners, faces), corners * (1.0, 1.0, 2.0), method="green")

Each call binds and warps. For several poses make an object of the class, which binds once.

Raises what the class, bind() and warp() raise, and InvalidOption for an unknown method.)");
}

} // namespace sinew::bindings
