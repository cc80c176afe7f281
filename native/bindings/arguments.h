// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/regions.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

namespace sinew::bindings {

namespace py = pybind11;

// The rule for every array argument: C-contiguous float64 is read in place. Other real types and layouts
// (float32, integers, Fortran order, slices, lists) are converted once. Text, objects, booleans and complex
// numbers raise a TypeError. A wrong shape raises InvalidMesh, InvalidConstraint or InvalidOption, depending
// on the argument.

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
