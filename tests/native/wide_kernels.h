// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/simd/kernel_set.h"

#include <vector>

namespace sinew {

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
