// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/arguments.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

namespace sinew::bindings {

namespace {

py::array any_array(const py::handle& object, const char* name)
{
    py::array array = py::array::ensure(object);
    if (!array) {
        PyErr_Clear();
        throw py::type_error(std::string(name) + ": cannot be read as an array");
    }
    return array;
}

[[noreturn]] void refuse_type(const py::array& array, const char* name, const char* wanted)
{
    throw py::type_error(std::string(name) + ": " + py::str(array.dtype()).cast<std::string>() + " given, " +
                         wanted + " needed");
}

} // namespace

FloatArray floats(const py::handle& object, const char* name)
{
    const py::array array = any_array(object, name);
    const char kind = array.dtype().kind();
    if (kind != 'f' && kind != 'i' && kind != 'u')
        refuse_type(array, name, "real numbers");
    return FloatArray(py::array_t<double, py::array::c_style | py::array::forcecast>(array));
}

std::vector<int> integers(const py::handle& object, const char* name)
{
    const py::array array = any_array(object, name);
    if (array.size() == 0)
        return {};
    const char kind = array.dtype().kind();
    if (kind != 'i' && kind != 'u')
        refuse_type(array, name, "integers");
    const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array);
    std::vector<int> values(wide.size());
    for (py::ssize_t k = 0; k < wide.size(); ++k) {
        const std::int64_t value = wide.data()[k];
        // A number that does not fit into 32 bits is no index of any mesh. It becomes -1, which later checks
        // refuse.
        const bool fits =
            value >= std::numeric_limits<int>::min() && value <= std::numeric_limits<int>::max();
        values[k] = fits ? static_cast<int>(value) : -1;
    }
    return values;
}

OptionalPoints::OptionalPoints(const py::object& object, const char* name)
{
    if (!object.is_none()) {
        array = floats(object, name);
        view.emplace(points<InvalidConstraint>(array, name));
    }
}

RowMatrix rows(const py::handle& object, py::ssize_t columns, const char* name)
{
    const FloatArray array = floats(object, name);
    if (array.ndim() != 2 || array.shape(0) == 0 || array.shape(1) != columns)
        throw InvalidOption(std::string(name) + ": give (n, " + std::to_string(columns) + ") numbers");
    return Eigen::Map<const RowMatrix>(array.data(), array.shape(0), columns);
}

std::vector<std::array<int, 2>> index_pairs(const py::handle& object, const char* name)
{
    const std::vector<int> ends = integers(object, name);
    if (ends.size() % 2 != 0)
        throw InvalidConstraint(std::string(name) + ": each has two ends");
    std::vector<std::array<int, 2>> pairs(ends.size() / 2);
    for (std::size_t k = 0; k < ends.size(); ++k)
        pairs[k / 2][k % 2] = ends[k];
    return pairs;
}

std::vector<double> numbers(const py::handle& object, const char* name)
{
    const FloatArray array = floats(object, name);
    if (array.ndim() > 1)
        throw InvalidOption(std::string(name) + ": give one number, or a flat array with one per vertex");
    return {array.data(), array.data() + array.size()};
}

Poses poses(const py::handle& object)
{
    const FloatArray array = floats(object, "poses");
    if (array.size() == 0)
        return {};
    if (array.ndim() != 3 || array.shape(1) != 3 || array.shape(2) != 4)
        throw InvalidConstraint("poses: the shape must be (k, 3, 4), one affine map per handle");
    Poses result(array.shape(0));
    for (std::size_t h = 0; h < result.size(); ++h)
        result[h] = Eigen::Map<const Pose>(array.data() + 12 * h);
    return result;
}

std::vector<Handle> handles(const py::handle& regions, const py::object& weights,
                            const py::object& continuity)
{
    if (!py::isinstance<py::sequence>(regions) && !py::isinstance<py::array>(regions))
        throw py::type_error("handles: a sequence of index arrays is needed, one per handle");
    std::vector<Handle> result;
    for (const py::handle region : regions) {
        const std::string name = "handle " + std::to_string(result.size());
        const py::array indices = any_array(region, name.c_str());
        if (indices.ndim() == 0)
            throw py::type_error("handles: " + name +
                                 " is a plain number; each handle is an array of indices, so write "
                                 "[[0, 7]] for one handle of two vertices");
        result.emplace_back().vertices = integers(indices, name.c_str());
    }

    const auto per_handle = [&](const py::object& values, const char* name) {
        if (!py::isinstance<py::sequence>(values) && !py::isinstance<py::array>(values))
            throw py::type_error(std::string(name) + ": a sequence is needed, with one entry per handle");
        if (py::len(values) != result.size())
            throw InvalidConstraint(std::string(name) + ": " + std::to_string(py::len(values)) +
                                    " entries for " + std::to_string(result.size()) + " handles");
    };
    if (!weights.is_none()) {
        per_handle(weights, "weights");
        for (std::size_t h = 0; h < result.size(); ++h) {
            const py::object entry = weights[py::int_(h)];
            if (entry.is_none())
                continue;
            const FloatArray array = floats(entry, "weights");
            if (array.ndim() == 0)
                result[h].weights.assign(result[h].vertices.size(), *array.data());
            else
                result[h].weights.assign(array.data(), array.data() + array.size());
        }
    }
    if (!continuity.is_none()) {
        const bool single = floats(continuity, "continuity").ndim() == 0;
        if (!single)
            per_handle(continuity, "continuity");
        const FloatArray array = floats(continuity, "continuity");
        for (std::size_t h = 0; h < result.size(); ++h)
            result[h].continuity = array.data()[single ? 0 : h];
    }
    return result;
}

std::optional<std::vector<bool>> flags(const py::object& object, std::size_t count, const char* name)
{
    if (object.is_none())
        return std::nullopt;
    const py::array array = any_array(object, name);
    if (array.size() > 0 && array.dtype().kind() != 'b')
        refuse_type(array, name, "a flag, or several");
    const auto values = py::array_t<bool, py::array::c_style | py::array::forcecast>(array);
    if (values.ndim() == 0)
        return std::vector<bool>(count, *values.data());
    return std::vector<bool>(values.data(), values.data() + values.size());
}

Progress progress(const py::object& callback)
{
    if (!callback.is_none() && !PyCallable_Check(callback.ptr()))
        throw py::type_error("progress: a callable (fraction, stage) or None is needed");
    // The caller's argument keeps the callable alive. So a borrowed pointer is enough, and the C++ function
    // may be destroyed without the GIL.
    PyObject* const function = callback.is_none() ? nullptr : callback.ptr();
    return Progress([function](double fraction, const char* stage) {
        const py::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0)
            throw py::error_already_set();
        if (!function)
            return true;
        const py::object answer = py::reinterpret_borrow<py::object>(function)(fraction, stage);
        return answer.is_none() || answer.cast<bool>();
    });
}

SinglePoints singles(const py::object& object, const char* name, py::ssize_t rows)
{
    using Array = py::array_t<float, py::array::c_style>;
    constexpr int fit = py::detail::npy_api::NPY_ARRAY_WRITEABLE_ | py::detail::npy_api::NPY_ARRAY_ALIGNED_;
    if (!py::isinstance<Array>(object) || (py::reinterpret_borrow<py::array>(object).flags() & fit) != fit)
        throw py::type_error(std::string(name) + ": a writable C-contiguous float32 array is needed");
    auto array = py::reinterpret_borrow<Array>(object);
    if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != 3)
        throw InvalidConstraint(std::string(name) + ": the shape must be (" + std::to_string(rows) + ", 3)");
    return {array.mutable_data(), rows, 3};
}

namespace {

void require_single(bool finite)
{
    if (!finite)
        throw InvalidConstraint(
            "the solution is not finite in single precision; check the scale of the poses");
}

} // namespace

void round_into(const Points& positions, SinglePoints& out) { require_single(round_points(positions, out)); }

void require_finite(const SinglePoints& positions) { require_single(are_finite(positions)); }

void require_finite(const Points& positions)
{
    if (!are_finite(positions))
        throw InvalidConstraint("the solution is not finite; check the scale of the poses");
}

const char* name_of(Reuse reuse)
{
    switch (reuse) {
    case Reuse::kept:
        return "kept";
    case Reuse::updated:
        return "updated";
    default:
        return "anew";
    }
}

py::array_t<double> to_numpy(Points&& points)
{
    auto owned = std::make_unique<Points>(std::move(points));
    const py::ssize_t rows = owned->rows();
    const double* data = owned->data();
    const py::capsule owner(owned.release(), [](void* p) { delete static_cast<Points*>(p); });
    return py::array_t<double>({rows, py::ssize_t{3}}, data, owner);
}

} // namespace sinew::bindings
