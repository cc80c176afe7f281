// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// The shares in the volume over a vertex's cell of a triangle: that of each of the three displacements, and
/// what its own has more.
constexpr double share_of_others = 7.0 / 36, share_of_own = 15.0 / 36;

/// The loops of the codings over triangles, four side by side. Every variant does the same operations in the
/// same order and fuses none, so results agree to the last bit.
struct DetailKernels
{
    /// The maps of some triangles times their areas, see ring_rotations.h.
    /// \param duals      (count, 3, 3) what each has from the shape before.
    /// \param points     (n, 3) the shape after.
    /// \param triangles  (count, 3) vertices.
    /// \param[out] maps  (count, 3, 3) column by column.
    void (*maps)(const double* duals, const double* points, const int* triangles, int count, double* maps);

    /// Volumes between two surfaces, see prism_between().
    /// \param coarse, fine  (n, 3) the base, and the surface.
    /// \param triangles     (count, 3) vertices.
    /// \param[out] volumes  (count, 3) of the cells at the corners.
    void (*volumes)(const double* coarse, const double* fine, const int* triangles, int count,
                    double* volumes);
    /// The derivatives of the sum of multipliers times volumes.
    /// \param multipliers  (n) of the cells of the vertices.
    /// \param[out] forces  (count, 3, 3) by the corners of the surface.
    void (*forces)(const double* coarse, const double* fine, const double* multipliers, const int* triangles,
                   int count, double* forces);
    /// How volumes change if the surface moves, to first order.
    /// \param move          (n, 3)
    /// \param[out] changes  (count, 3) of the cells at the corners.
    void (*changes)(const double* coarse, const double* fine, const double* move, const int* triangles,
                    int count, double* changes);

    static const DetailKernels baseline, avx2;
};

} // namespace sinew
