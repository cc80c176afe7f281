// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace sinew {

// The options of a method are a struct with their defaults, and a static function table(), which says the
// rest of each: its name, what a bind makes of a change, its range and a sentence. Checks, the differences
// between two objects, the arguments in Python and their documentation follow from the table, so that an
// option is written down once.
//
//     struct SmoothingOptions
//     {
//         int sweeps = 4;
//
//         static constexpr auto table()
//         {
//             return std::tuple{
//                 option("sweeps", &SmoothingOptions::sweeps, Rebind::update, at_least(0), "how often ...")};
//         }
//     };

/// What a bind takes over from an object that differs in an option.
enum class Rebind {
    whole,  ///< everything, as only solves read the option
    update, ///< a part
    anew    ///< nothing
};

/// The numbers that an option may be.
struct Range
{
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool with_least = true, with_most = true;

    bool contains(double value) const;
    /// ">= 0", "> 0", "in [0, 1)", "1 to 8"; empty where every finite number will do.
    std::string words(bool whole_numbers) const;
};
constexpr Range any_number() { return {}; }
constexpr Range at_least(double least) { return {.least = least}; }
constexpr Range more_than(double bound) { return {.least = bound, .with_least = false}; }
constexpr Range between(double least, double most) { return {.least = least, .most = most}; }
/// In [least, bound).
constexpr Range from_to_below(double least, double bound)
{
    return {.least = least, .most = bound, .with_most = false};
}

/// An option of a method: a member of type T of its struct, and what is to be said about it.
template <class Options, class T>
struct Option
{
    const char* name; ///< of the argument in Python
    T Options::* member;
    Rebind rebind;
    Range range;      ///< of a number, or of each of several
    const char* text; ///< a sentence without a capital letter and without a full stop
    const char* shape = ""; ///< of several numbers that may be given instead of one
};

template <class Options, class T>
constexpr Option<Options, T> option(const char* name, T Options::* member, Rebind rebind, Range range,
                                    const char* text)
{
    return {name, member, rebind, range, text};
}
/// For an option that is no number.
template <class Options, class T>
constexpr Option<Options, T> option(const char* name, T Options::* member, Rebind rebind, const char* text)
{
    return {name, member, rebind, {}, text};
}

/// For one number, or one for each vertex.
template <class Options>
constexpr auto painted_option(const char* name, std::vector<double> Options::* member, Rebind rebind,
                              Range range, const char* text)
{
    return Option<Options, std::vector<double>>{name, member, rebind, range, text, "(n,) painted"};
}
/// For one number, or one for each of the tools or curves of a control.
template <class Options>
constexpr auto option_of_each(const char* name, std::vector<double> Options::* member, Range range,
                              const char* text)
{
    return Option<Options, std::vector<double>>{name, member, Rebind::anew, range, text, "(k,)"};
}

// Two that iterative methods have.
template <class Options>
constexpr auto iteration_limit(int Options::* member,
                               const char* text = "largest number of iterations of a solve")
{
    return option("max_iterations", member, Rebind::whole, at_least(1), text);
}
template <class Options>
constexpr auto
stopping_tolerance(double Options::* member,
                   const char* text = "a solve stops when the relative decrease of the energy is below this "
                                      "twice in succession")
{
    return option("tolerance", member, Rebind::whole, at_least(0), text);
}

/// An enumerator and its name in Python. An enumeration that is an option has a function choices(E), which
/// gives an array of them.
template <class E>
struct Choice
{
    const char* name;
    E value;
};
template <class E>
Choice(const char*, E) -> Choice<E>;

/// Calls f(option) for each row of the table.
template <class Options, class F>
constexpr void for_each_option(F&& f)
{
    std::apply([&](const auto&... option) { (f(option), ...); }, Options::table());
}

/// \throw InvalidOption  the number is not in the range, or not finite.
void require_in_range(double value, const Range& range, const char* name);

/// \throw InvalidOption  a number of the options is not in its range, or not finite. Painted ones are not
///   looked at, see operators/painted.h.
template <class Options>
void require_valid(const Options& options)
{
    for_each_option<Options>([&]<class T>(const Option<Options, T>& option) {
        if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
            require_in_range(static_cast<double>(options.*option.member), option.range, option.name);
    });
}

template <class T>
bool same(const T& a, const T& b)
{
    return a == b;
}
/// Whether both point to the same value, or to none.
template <class T>
bool same(const std::shared_ptr<T>& a, const std::shared_ptr<T>& b)
{
    return a && b ? *a == *b : a == b;
}
/// Arrays; NaN, for no value, is equal to itself.
template <class T>
    requires std::is_base_of_v<Eigen::PlainObjectBase<T>, T>
bool same(const T& a, const T& b)
{
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           std::equal(a.data(), a.data() + a.size(), b.data(),
                      [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// `names`, followed by those of the options that differ and that a bind reads.
template <class Options>
std::vector<std::string> changed(const Options& own, const Options& other,
                                 std::vector<std::string> names = {})
{
    for_each_option<Options>([&]<class T>(const Option<Options, T>& option) {
        if (option.rebind != Rebind::whole && !same(own.*option.member, other.*option.member))
            names.emplace_back(option.name);
    });
    return names;
}

/// Whether a bind can take a part over from an object with another value of this option.
template <class Options>
bool is_updated(const std::string& name)
{
    bool updated = false;
    for_each_option<Options>(
        [&](const auto& option) { updated |= name == option.name && option.rebind == Rebind::update; });
    return updated;
}

} // namespace sinew
