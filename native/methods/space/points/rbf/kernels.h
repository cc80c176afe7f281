// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// phi(r). With the compact ones, r is in units of their radius, and beyond it they are 0.
enum class RbfFunction {
    triharmonic, ///< r^3
    biharmonic,  ///< -r
    wendland_c0, ///< (1 - r)^2
    wendland_c2, ///< (1 - r)^4 (4 r + 1)
    wendland_c4  ///< (1 - r)^6 (35 r^2 + 18 r + 3) / 3
};
constexpr int rbf_function_count = 5;

inline bool is_compact(RbfFunction function) { return function >= RbfFunction::wendland_c0; }

/// Values of phi at eight points at a time, given as (3, 8): all x, all y, all z. Every variant does the same
/// operations in the same order and fuses none, so results agree to the last bit. Each array holds one entry
/// per function.
struct RbfKernels
{
    /// values (count, 8) = phi(|x - c| scale)
    /// \param centres  (count, 3)
    void (*values[rbf_function_count])(const double* centres, int count, double scale, const double* points,
                                       double* values);
    /// sums (3, 8) += sum_j weights_j phi(|x - c_j| scale)
    /// \param table  (count, 6) centre and weight of each.
    void (*sums[rbf_function_count])(const double* table, int count, double scale, const double* points,
                                     double* sums);

    static const RbfKernels baseline, avx2, avx512;
};

} // namespace sinew
