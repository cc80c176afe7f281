// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/regions.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sinew::bindings {

namespace py = pybind11;

// The rule for every array argument: C-contiguous float64 is read in place. Other real types and layouts
// (float32, integers, Fortran order, slices, lists) are converted once. Text, objects, booleans and complex
// numbers raise a TypeError. A wrong shape raises InvalidMesh, InvalidConstraint or InvalidOption, depending
// on the argument.

/// A type, as signatures and the types for editors write it.
template <std::size_t n>
struct TypeText
{
    consteval TypeText(const char (&given)[n]) { std::copy_n(given, n, text); }
    char text[n];
};

/// Any object. Signatures say that it is of the type in the text.
template <TypeText text>
class Typed : public py::object
{
    static bool is_any(PyObject* /*object*/) { return true; }

public:
    PYBIND11_OBJECT_DEFAULT(Typed, py::object, is_any)
    using py::object::object;
};

using ArrayLike = Typed<"numpy.typing.ArrayLike">;
using OptionalArray = Typed<"numpy.typing.ArrayLike | None">;
using ArrayLikes = Typed<"collections.abc.Sequence[numpy.typing.ArrayLike]">;
using OptionalArrays = Typed<"collections.abc.Sequence[numpy.typing.ArrayLike | None] | None">;
using OptionalFlags = Typed<"bool | collections.abc.Sequence[bool] | None">;
using FaceArrays = Typed<"numpy.typing.ArrayLike | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike]">;
using ArrayOrMesh = Typed<"numpy.typing.ArrayLike | SurfaceMesh">;
using OptionalArrayOrMesh = Typed<"numpy.typing.ArrayLike | SurfaceMesh | None">;
using Names = Typed<"str | collections.abc.Sequence[str]">;
using Callback = Typed<"collections.abc.Callable[[float, str], bool | None] | None">;
using Out = Typed<"numpy.typing.NDArray[numpy.float32] | None">; ///< an array to write into
using Singles = Typed<"numpy.typing.NDArray[typing.Any]">; ///< of double precision, or what `out` was
using Solved = Typed<"tuple[numpy.typing.NDArray[typing.Any], SolveReport]">;

/// The array must live as long as any view of it, so the bindings keep a reference.
using FloatArray = py::array_t<double, py::array::c_style>;

/// \throw py::type_error  naming the argument.
FloatArray floats(const py::handle& object, const char* name);

/// Integers of any width, checked against 32 bits.
std::vector<int> integers(const py::handle& object, const char* name);

/// (n, 3) view of an array. Throws an E for another shape.
template <class E>
PointsView points(const FloatArray& array, const char* name)
{
    if (array.ndim() != 2 || array.shape(1) != 3) {
        std::string shape;
        for (py::ssize_t k = 0; k < array.ndim(); ++k)
            shape += (k ? ", " : "") + std::to_string(array.shape(k));
        throw E(std::string(name) + ": shape (" + shape + ") is not (n, 3)");
    }
    return {array.data(), array.shape(0), 3};
}

/// None, or an (n, 3) array and a view of it.
struct OptionalPoints
{
    /// \throw InvalidConstraint  another shape.
    OptionalPoints(const py::object& object, const char* name);

    FloatArray array;
    std::optional<PointsView> view;
};

/// One number, or one per vertex.
std::vector<double> numbers(const py::handle& object, const char* name);

/// (n, columns) numbers.
/// \throw InvalidOption  another shape.
RowMatrix rows(const py::handle& object, py::ssize_t columns, const char* name);

/// (s, 2) indices.
/// \throw InvalidConstraint  an odd number of them.
std::vector<std::array<int, 2>> index_pairs(const py::handle& object, const char* name);

/// (k, 3, 4) -> poses.
/// \throw InvalidConstraint  another shape.
Poses poses(const py::handle& object);

/// The handles from the arguments of set_handles() in Python.
std::vector<Handle> handles(const py::handle& regions, const py::object& weights,
                            const py::object& continuity);

/// None, one flag, or one per handle.
std::optional<std::vector<bool>> flags(const py::object& object, std::size_t count,
                                       const char* name = "from_rest");

/// Progress that calls a Python callable, or nothing for None. It takes the GIL for that, and lets Ctrl-C
/// cancel.
Progress progress(const py::object& callback);

/// (rows, 3) view of a C-contiguous, writable float32 array that the caller wants to be filled.
/// \throw py::type_error     for anything else; it names the argument.
/// \throw InvalidConstraint  another shape.
using SinglePoints = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>;
SinglePoints singles(const py::object& object, const char* name, py::ssize_t rows);

/// Rounds to single precision. Needs no GIL.
/// \throw InvalidConstraint  a rounded position is not finite.
void round_into(const Points& positions, SinglePoints& out);

/// Needs no GIL.
/// \throw InvalidConstraint  a position is not finite.
void require_finite(const SinglePoints& positions);
void require_finite(const Points& positions);

/// "anew", "updated" or "kept".
const char* name_of(Reuse reuse);

/// Moves points into a NumPy array without a copy.
py::array_t<double> to_numpy(Points&& points);

template <class T>
py::array_t<T> to_numpy(const std::vector<T>& values)
{
    return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

} // namespace sinew::bindings

namespace pybind11::detail {

template <sinew::bindings::TypeText text>
struct handle_type_name<sinew::bindings::Typed<text>>
{
    static constexpr auto name = const_name(text.text);
};

} // namespace pybind11::detail
