// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/bindings/arguments.h"
#include "native/core/options.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace sinew::bindings {

/// An enumeration whose enumerators have names in Python.
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E value) { choices(value); };

/// The name of an enumerator.
template <NamedEnum E>
const char* name_of(E value)
{
    const auto all = choices(E{});
    return std::ranges::find(all, value, &Choice<E>::value)->name;
}

/// The name of an enumerator, as an argument.
template <NamedEnum E>
struct Chosen
{
    std::string name;

    /// \param option  the name of the argument.
    /// \throw InvalidOption  an unknown name; the message lists the known ones.
    E value(const char* option) const
    {
        std::string known;
        for (const auto& [choice, value] : choices(E{})) {
            if (name == choice)
                return value;
            known += (known.empty() ? "'" : ", '") + std::string(choice) + "'";
        }
        throw InvalidOption(std::string(option) + ": '" + name + "' is not one of " + known);
    }
};

/// How an option of type T is given in Python: the type of the argument, its default, and what is made of it.
template <class T>
struct Argument
{
    using type = T;
    static py::object initial(const T& value) { return py::cast(value); }
    static void read(const T& given, const char* /*name*/, T& value) { value = given; }
};

template <NamedEnum E>
struct Argument<E>
{
    using type = Chosen<E>;
    static py::object initial(E value) { return py::str(name_of(value)); }
    static void read(const Chosen<E>& given, const char* name, E& value) { value = given.value(name); }
};

/// One or several of them, by name.
template <NamedEnum E>
struct Argument<std::vector<E>>
{
    using type = Names;
    static py::object initial(const std::vector<E>& values) { return py::str(name_of(values.front())); }
    static void read(const type& given, const char* name, std::vector<E>& values)
    {
        values.clear();
        if (py::isinstance<py::str>(given))
            values.push_back(Chosen<E>{given.cast<std::string>()}.value(name));
        else
            for (const py::handle one : given)
                values.push_back(Chosen<E>{one.cast<std::string>()}.value(name));
    }
};

/// A number, or one for each of several elements. A default of several numbers is None; elsewhere None is
/// refused.
template <>
struct Argument<std::vector<double>>
{
    using type = OptionalArray;
    static py::object initial(const std::vector<double>& values)
    {
        return values.size() == 1 ? py::object(py::float_(values.front())) : py::none();
    }
    static void read(const type& given, const char* name, std::vector<double>& values)
    {
        if (!given.is_none() || values.size() == 1)
            values = numbers(given, name);
    }
};

/// For an argument that is None where the option is empty.
template <class T, class Given>
struct OptionalArgument
{
    using type = Given;
    static py::object initial(const T& /*value*/) { return py::none(); }
};

template <>
struct Argument<std::vector<int>> : OptionalArgument<std::vector<int>, OptionalArray>
{
    static void read(const type& given, const char* name, std::vector<int>& values)
    {
        if (!given.is_none())
            values = integers(given, name);
    }
};

template <>
struct Argument<std::vector<bool>> : OptionalArgument<std::vector<bool>, OptionalFlags>
{
    static void read(const type& given, const char* name, std::vector<bool>& values)
    {
        values = flags(given, 1, name).value_or(std::vector<bool>{});
    }
};

template <>
struct Argument<std::vector<std::array<int, 2>>>
    : OptionalArgument<std::vector<std::array<int, 2>>, OptionalArray>
{
    static void read(const type& given, const char* name, std::vector<std::array<int, 2>>& values)
    {
        if (!given.is_none())
            values = index_pairs(given, name);
    }
};

template <>
struct Argument<Points> : OptionalArgument<Points, OptionalArray>
{
    static void read(const type& given, const char* name, Points& value)
    {
        if (const OptionalPoints points(given, name); points.view)
            value = *points.view;
    }
};

template <>
struct Argument<RowMatrix> : OptionalArgument<RowMatrix, OptionalArray>
{
    static void read(const type& given, const char* name, RowMatrix& value)
    {
        if (!given.is_none())
            value = rows(given, 2, name);
    }
};

template <class T>
struct Argument<std::shared_ptr<const T>> : OptionalArgument<std::shared_ptr<const T>, const T*>
{
    static void read(const T* given, const char* /*name*/, std::shared_ptr<const T>& value)
    {
        if (given)
            value = std::make_shared<const T>(*given);
    }
};

/// What an argument is, for its documentation: "mesh  SurfaceMesh, the rest shape".
struct Described
{
    std::string name, text;
};

/// The documentation of a constructor: its arguments below each other, and what it raises.
std::string documentation(const std::vector<Described>& arguments, const std::string& raises);

template <class Options>
std::vector<Described> described_options()
{
    std::vector<Described> described;
    for_each_option<Options>([&]<class T>(const Option<Options, T>& option) {
        const std::string numbers = option.range.words(std::is_same_v<T, int>);
        std::string range = numbers;
        if (*option.shape != '\0')
            range = "a number" + (numbers.empty() ? "" : " " + numbers) + ", or " + option.shape;
        described.push_back({option.name, range.empty() ? option.text : range + ": " + option.text});
    });
    return described;
}

/// Gives a class its constructor: arguments of its own, and then one keyword for each option of the table.
///
///     define_constructor(
///         primo, +[](const PrimoOptions& options, const SurfaceMesh& mesh) { ... }, {{"mesh", "..."}},
///         "Raises InvalidOption.", py::arg("mesh"), py::kw_only());
///
/// \param make      makes a shared pointer to the object of the options and its own arguments. It holds the
///   GIL.
/// \param own       what these arguments are.
/// \param raises    the last paragraph of the documentation.
/// \param arguments py::arg and py::kw_only for these arguments.
template <class Options, class Class, class Pointer, class... Own, class... Arguments>
void define_constructor(Class& defined, Pointer (*make)(const Options&, Own...), std::vector<Described> own,
                        const std::string& raises, const Arguments&... arguments)
{
    std::ranges::move(described_options<Options>(), std::back_inserter(own));
    const std::string text = documentation(own, raises);
    std::apply(
        [&]<class... T>(const Option<Options, T>&... option) {
            defined.def(py::init([make](Own... values, const typename Argument<T>::type&... given) {
                            Options options;
                            std::apply(
                                [&](const auto&... row) {
                                    (Argument<T>::read(given, row.name, options.*row.member), ...);
                                },
                                Options::table());
                            return make(options, std::forward<Own>(values)...);
                        }),
                        arguments...,
                        (py::arg(option.name) = Argument<T>::initial(Options{}.*option.member))...,
                        text.c_str());
        },
        Options::table());
}

} // namespace sinew::bindings

namespace pybind11::detail {

template <sinew::bindings::NamedEnum E>
struct type_caster<sinew::bindings::Chosen<E>>
{
    /// "typing.Literal['harmonic', 'geodesic']"
    static constexpr auto literal()
    {
        constexpr auto all = choices(E{});
        constexpr std::string_view head = "typing.Literal[", comma = ", ", quote = "'", tail = "]";
        constexpr std::size_t length = [&] {
            std::size_t sum = head.size() + tail.size() + (all.size() - 1) * comma.size();
            for (const auto& choice : all)
                sum += std::string_view(choice.name).size() + 2 * quote.size();
            return sum;
        }();
        descr<length> written;
        char* end = written.text;
        const auto write = [&](std::string_view text) { end = std::copy(text.begin(), text.end(), end); };
        write(head);
        for (std::size_t k = 0; k < all.size(); ++k) {
            write(k > 0 ? comma : "");
            write(quote);
            write(all[k].name);
            write(quote);
        }
        write(tail);
        return written;
    }
    PYBIND11_TYPE_CASTER(sinew::bindings::Chosen<E>, literal());

    bool load(handle source, bool /*convert*/)
    {
        if (!isinstance<str>(source))
            return false;
        value.name = source.cast<std::string>();
        return true;
    }
};

} // namespace pybind11::detail
