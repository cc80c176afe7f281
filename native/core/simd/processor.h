// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// The sets of instructions that an x86 processor has, and whose registers the system saves.
struct Processor
{
    bool avx2 = false;
    bool fma = false;
    bool avx512 = false; ///< with its parts F, VL and DQ
};

/// This processor, as it describes itself. (`__builtin_cpu_supports` reads a table that is empty in the runtime
/// library of zig.)
const Processor& processor();

} // namespace sinew
