// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/simd/kernel_set.h"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace sinew {

/// A number that no other bits of these values are likely to have. Kernels add, multiply, divide and take
/// roots, and fuse nothing, so it is the same on every processor and with every compiler.
inline std::uint64_t digest(std::span<const double> values)
{
    std::uint64_t sum = 0;
    for (const double value : values)
        sum = (sum ^ std::bit_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15ULL + (sum >> 29);
    return sum;
}

/// The sets of kernels wider than the baseline that this processor runs.
template <class Kernels>
std::vector<const Kernels*> wide_kernels()
{
    std::vector<const Kernels*> found;
    for (const Instructions instructions : {Instructions::avx2, Instructions::avx512})
        if (const Kernels* kernels = kernels_with<Kernels>(instructions))
            found.push_back(kernels);
    return found;
}

/// All of them, the baseline first.
template <class Kernels>
std::vector<const Kernels*> every_kernels()
{
    std::vector<const Kernels*> found = wide_kernels<Kernels>();
    found.insert(found.begin(), &Kernels::baseline);
    return found;
}

} // namespace sinew
