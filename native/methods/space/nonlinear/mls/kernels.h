// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// The maps among which moving least squares choose.
enum class MlsMaps { affine, similarity, rigid };

/// What moves in one frame: single points, then elements that move by affine maps, D(p) = B p + b.
struct MlsFrame
{
    const double* points; ///< (point_count, 6) places at rest, and moves
    const double* maps;   ///< (map_count, 12) B row by row, each row followed by its entry of b
    int point_count, map_count;
    MlsMaps kind;
};

/// Sums over all elements at a point v, with p - v for p; see Mls.
struct MlsSums
{
    double total[4];         ///< W = sum w
    double places[3][4];     ///< sum w p
    double moves[3][4];      ///< sum w D
    double spread[6][4];     ///< C = sum w p p^T about the mean: xx, xy, xz, yy, yz, zz
    double together[3][3][4]; ///< sum w D p^T about the means, so that M C = C + together
};

/// Four points at a time. Every variant does the same operations in the same order and fuses none, so results
/// agree to the last bit.
struct MlsKernels
{
    /// \param weights     (point_count + 10 map_count, 4): w of each point; w, w p and w p p^T of each map.
    /// \param places      (4, 3) the points v.
    /// \param[out] sums   for lanes that are not safe.
    /// \param[out] moves  (4, 3)
    /// \return bit k: whether the move of point k is safe; otherwise the caller computes it from the sums.
    int (*move_singles)(const MlsFrame& frame, const float* weights, const double* places, MlsSums& sums,
                        double* moves);
    int (*move_doubles)(const MlsFrame& frame, const double* weights, const double* places, MlsSums& sums,
                        double* moves);

    static const MlsKernels baseline, avx2;
};

} // namespace sinew
