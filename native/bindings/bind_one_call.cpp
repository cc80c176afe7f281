// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"
#include "native/core/errors.h"
#include "native/methods/space/method.h"
#include "native/methods/surface/method.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace sinew::bindings {

namespace {

using Control = Typed<"numpy.typing.ArrayLike | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike]">;
using Found = Typed<"numpy.typing.NDArray[numpy.float64]">;
using Classes = std::map<std::string, py::object>; ///< by the ids of their methods

/// "ThinShell" -> "thin_shell"
std::string id_of(const std::string& name)
{
    std::string id;
    for (const char letter : name) {
        if (std::isupper(static_cast<unsigned char>(letter)) && !id.empty())
            id += '_';
        id += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
    return id;
}

/// The names of what a constructor takes, as its signature states them in the first line of its documentation;
/// none for a class without a constructor.
std::vector<std::string> arguments_of(const py::handle& type)
{
    static const std::regex argument(", (\\w+): ");
    const auto text = type.attr("__init__").attr("__doc__").cast<std::string>();
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(text.find('\n'), text.size()));
    std::vector<std::string> names;
    for (std::sregex_iterator found(text.begin(), end, argument), none; found != none; ++found)
        names.push_back((*found)[1]);
    return names;
}

/// Adds the classes of this module that are derived from a type and can be made.
void add_derived(const py::handle& type, Classes& classes)
{
    for (const py::handle derived : type.attr("__subclasses__")()) {
        if (!derived.attr("__module__").equal(type.attr("__module__")))
            continue; // a user's class
        if (!arguments_of(derived).empty())
            classes[id_of(derived.attr("__name__").cast<std::string>())] =
                py::reinterpret_borrow<py::object>(derived);
        add_derived(derived, classes);
    }
}

bool is_among(const std::vector<std::string>& names, const std::string& name)
{
    return std::ranges::find(names, name) != names.end();
}

std::string listed(const std::vector<std::string>& names)
{
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? "'" : ", '") + name + "'";
    return text;
}

/// The class of the method with this id, among those whose constructor's arguments are accepted.
/// \throw InvalidOption  there is none; `option` is the argument with the id.
template <class Base, class Accepts>
py::object class_of(const std::string& id, const char* option, const Accepts& accepts)
{
    Classes classes;
    add_derived(py::type::of<Base>(), classes);
    std::erase_if(classes, [&](const auto& entry) { return !accepts(arguments_of(entry.second)); });
    if (const auto found = classes.find(id); found != classes.end())
        return found->second;
    std::vector<std::string> known;
    for (const auto& [name, type] : classes)
        known.push_back(name);
    throw InvalidOption(std::string(option) + ": '" + id + "' is not one of " + listed(known));
}

/// An object of the class, which is made of one thing and options.
/// \throw InvalidOption  the class has no such option.
py::object make(const py::object& type, const std::string& id, const py::object& of, const py::dict& options)
{
    std::vector<std::string> known = arguments_of(type);
    known.erase(known.begin()); // what it is made of
    std::ranges::sort(known);
    const std::string refusal =
        ": '" + id +
        (known.empty() ? "' has no options" : "' has no such option; its options are " + listed(known));
    for (const auto& [key, value] : options)
        if (const auto name = key.cast<std::string>(); !is_among(known, name))
            throw InvalidOption(name + refusal);
    return type(of, **options);
}

py::object mesh_of(const py::handle& points, const py::handle& faces)
{
    return py::type::of<SurfaceMesh>()(points, faces);
}

Found deform_once(const ArrayLike& points, const FaceArrays& faces, const ArrayLikes& handles,
                  const ArrayLike& poses, const std::string& method, const py::kwargs& options)
{
    const auto any = [](const auto&) { return true; };
    const auto of_mesh_alone = [](const auto& arguments) { return !is_among(arguments, "base"); };
    const py::object mesh = mesh_of(points, faces), type = class_of<SurfaceMethod>(method, "method", any);
    if (!of_mesh_alone(arguments_of(type))) {
        const std::string base = options.contains("base") ? py::str(options["base"]) : "thin_shell";
        options["base"] = class_of<SurfaceMethod>(base, "base", of_mesh_alone)(mesh);
    }
    const py::object made = make(type, method, mesh, options);
    made.attr("set_handles")(handles);
    return made.attr("solve")(poses).cast<py::tuple>()[0];
}

Found warp_once(const ArrayLike& points, const Control& cage, const ArrayLike& posed_cage,
                const std::string& method, const py::kwargs& options)
{
    const py::object type = class_of<SpaceMethod>(method, "method", [](const auto& arguments) {
        return arguments.front() != "mesh" && !is_among(arguments, "base");
    });
    const bool has_faces = arguments_of(type).front() == "cage";
    const bool is_pair = py::isinstance<py::tuple>(cage) && py::len(cage) == 2;
    if (has_faces && !is_pair)
        throw InvalidConstraint("cage: '" + method + "' takes a tuple (points, faces)");
    const py::object control =
        has_faces ? mesh_of(cage[py::int_(0)], cage[py::int_(1)]) : py::object(floats(cage, "cage"));
    const py::object made = make(type, method, control, options);
    made.attr("bind")(points);
    return made.attr("warp")(posed_cage);
}

} // namespace

void bind_one_call(py::module_& module)
{
    module.def("deform", &deform_once, py::arg("points"), py::arg("faces"), py::arg("handles"),
               py::arg("poses"), py::arg("method") = "arap",
               R"(Deform a mesh once by handles on it -> (n, 3) positions.

points   (n, 3) rest positions, in any unit.
faces    as SurfaceMesh takes them: (m, 3) or (m, 4) indices, or a tuple (counts, indices).
handles  sequence of vertex index arrays, one per handle; a region that stays is a handle, too.
poses    (k, 3, 4) affine map of each handle from its rest to its posed state, in the frame of the points.
method   the id of a surface method, which is the name of its class in small letters: 'arap' is Arap
         [Sorkine & Alexa 2007], 'thin_shell' is ThinShell [Botsch & Kobbelt 2004].
options  those of the class. Multiresolution takes the id of another method as `base`, or else 'thin_shell'.

    import numpy as np
    import sinew_native as sn

    points = np.array([(x, y, 0.0) for y in range(3) for x in range(3)])
    faces = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, 2, 3] = 1.0  # lifts the last row
    positions = sn.deform(points, faces, [[0, 1, 2], [6, 7, 8]], poses, method="arap", smoothness=0.001)

Each call makes an object of the class, binds it and solves. For several poses keep such an object: set_handles()
factorises, solve() costs a small part of that.

Raises InvalidOption for an unknown method or option, and what the class, set_handles() and solve() raise:
InvalidMesh, InvalidConstraint, InvalidOption or FactorizationFailed.)");
    module.def("warp", &warp_once, py::arg("points"), py::arg("cage"), py::arg("posed_cage"),
               py::arg("method") = "green",
               R"(Warp points once by a cage or by control points around them -> (n, 3) positions.

points      (n, 3) rest positions, in any unit; for most cages they have to be inside.
cage        (points (c, 3), faces), the closed cage at rest, in the frame of the points; for a method whose control
            has no faces, such as 'rbf', (c, 3) points alone.
posed_cage  (c, 3) where these points are in the pose.
method      the id of a space method, which is the name of its class in small letters: 'green' is Green
            [Lipman et al. 2008], 'mean_value' is MeanValue [Ju et al. 2005], 'rbf' is Rbf.
options     those of the class.

    import numpy as np
    import sinew_native as sn

    corners = np.array([(x, y, z) for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    points = [(0.0, 0.0, 0.5), (0.2, 0.0, 0.0)]
    positions = sn.warp(points, (corners, faces), corners * (1.0, 1.0, 2.0), method="mean_value", precision="double")

Each call makes an object of the class, binds it and warps. For several poses keep such an object: bind() computes the
weights of all points, warp() multiplies them.

Raises InvalidOption for an unknown method or option, and what the class, bind() and warp() raise: InvalidMesh,
InvalidConstraint, PointsOutside, InvalidOption or FactorizationFailed.)");
}

} // namespace sinew::bindings
