// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"

#include <string>
#include <vector>

namespace sinew::bindings {

/// None, or a pair (elements, sharpness); one sharpness stands for all.
inline std::vector<double> sharpness(const py::object& pair, const char* name, std::vector<int>& elements,
                                     py::ssize_t columns)
{
    if (pair.is_none())
        return {};
    if (!py::isinstance<py::sequence>(pair) || py::len(pair) != 2)
        throw py::type_error(std::string(name) + ": a pair (elements, sharpness) is needed");
    const py::object first = pair[py::int_(0)];
    elements = integers(first, name);
    const auto count = static_cast<py::ssize_t>(elements.size()) / columns;
    if (columns > 1 && !elements.empty()) {
        const py::array shape = py::array::ensure(first);
        if (shape.ndim() != 2 || shape.shape(1) != columns)
            throw InvalidOption(std::string(name) + ": the edges must be (k, 2) pairs of vertices");
    }
    const FloatArray values = floats(pair[py::int_(1)], name);
    if (values.ndim() == 0)
        return std::vector<double>(static_cast<std::size_t>(count), *values.data());
    return {values.data(), values.data() + values.size()};
}

/// \param creases, corners  None, or a pair (elements, sharpness).
/// \param options           SubdivisionOptions, or what else has such creases.
template <class Options>
void read_creases(const py::object& creases, const py::object& corners, Options& options)
{
    std::vector<int> ends;
    options.crease_sharpness = sharpness(creases, "creases", ends, 2);
    for (std::size_t k = 0; k + 1 < ends.size(); k += 2)
        options.crease_edges.push_back({ends[k], ends[k + 1]});
    options.corner_sharpness = sharpness(corners, "corners", options.corner_vertices, 1);
}

} // namespace sinew::bindings
