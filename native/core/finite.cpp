// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/finite.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <sstream>

namespace sinew {

namespace {

/// \param are_finite  are_finite(begin, end) for rows.
template <class Rows>
bool of_all_rows(Eigen::Index rows, Rows&& are_finite)
{
    std::atomic<bool> finite{true};
    parallel_chunks(static_cast<int>(rows), 8192, [&](int begin, int end) {
        if (!are_finite(begin, end))
            finite = false;
    });
    return finite;
}

/// \param number  number(k) is the k-th number of the positions
template <class Number>
bool single_rows(Eigen::Index rows, Number&& number)
{
    return of_all_rows(rows, [&](int begin, int end) {
        std::uint32_t largest = 0; // bits without the sign are ordered like the magnitudes of the numbers
        for (std::size_t k = 3 * static_cast<std::size_t>(begin); k < 3 * static_cast<std::size_t>(end); ++k)
            largest = std::max(largest, std::bit_cast<std::uint32_t>(number(k)) & 0x7FFFFFFFU);
        return largest < 0x7F800000U;
    });
}

} // namespace

bool are_finite(const Points& points)
{
    return of_all_rows(points.rows(),
                       [&](int begin, int end) { return all_finite(points.middleRows(begin, end - begin)); });
}

bool are_finite(const SinglePoints& points)
{
    return single_rows(points.rows(), [own = points.data()](std::size_t k) { return own[k]; });
}

bool round_points(const Points& points, SinglePoints& rounded)
{
    return single_rows(rounded.rows(), [from = points.data(), to = rounded.data()](std::size_t k) {
        return to[k] = static_cast<float>(from[k]);
    });
}

std::string shortest(double number, int digits)
{
    std::ostringstream text;
    text.precision(digits);
    text << number;
    return text.str();
}

} // namespace sinew
