// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/harmonic/data.h"
#include "native/methods/space/cage/harmonic/layers.h"
#include "native/methods/space/cage/harmonic/pattern.h"
#include "native/solvers/dense/system.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// Harmonic functions of a cage by boundary elements, one per control point of the cage:
///
///     phi_v(x) = S(x) q_v + D(x) g_v
///
/// D is the double layer potential of the exact data g_v on the cage's faces, S the single layer potential of
/// the unknown flux q_v on the panels of a HarmonicPattern. q_v solves T S(x_b) q_v = T (g_v - D(x_b) g_v),
/// where x_b are three points per panel just inside the cage and T the hat functions of the panels times
/// their areas. Every pattern can represent the flux of constant and linear data exactly. So up to rounding,
/// phi sums to one and has linear precision with any pattern.
///
/// The flux on triangles that are many radii away from a point is replaced by its linear part. This changes
/// weights by a fraction of the pattern's error and keeps both properties.
class HarmonicBoundary
{
public:
    /// Cost: O((triangles * unknowns)^3) time, O((triangles * unknowns)^2) memory.
    /// \param level  of harmonic_pattern().
    /// \throw InvalidMesh  triangles have no area, or faces touch so that the system is singular.
    /// \throw OutOfMemory, Cancelled
    HarmonicBoundary(const Cage& cage, int level, const Progress& progress);

    int unknowns() const { return pattern_.unknowns * static_cast<int>(triangles_.size()); }

    /// \param block         (b, 3) points in the frame of the cage.
    /// \param[out] weights  (b, c) phi, which may be slightly negative.
    /// \param[out] winding  (b) how often the cage winds around each point: 1 inside, 0 outside.
    void evaluate(PointsView block, RowMatrix& weights, std::vector<double>& winding) const;

    /// The difference between phi and the data at four points per triangle: the root mean square over these
    /// points, where squares are summed over the vertices, and the largest magnitude. The error of phi is
    /// harmonic, so nowhere is it larger than on the cage.
    double residual_rms() const { return residual_rms_; }
    double residual_max() const { return residual_max_; }

private:
    struct Block;
    struct Near;
    void place(const Cage& cage);
    void cut();
    void assemble(DenseSystem& system, int begin, int end) const;
    void check(const Cage& cage, const DenseSystem& system, const std::vector<double>& diagonal) const;
    void keep(const DenseSystem& system);
    void measure_residual(const Progress& progress);
    void evaluate(const Block& block, double* rows, int stride) const;
    void gather_near(int triangle, const Block& block, Near& near) const;
    void add_double_layer(int triangle, const Block& block, const double* fields, double* rows,
                          int stride) const;
    Vector3 inside_point(int triangle, const Vector3& hats) const;

    HarmonicPattern pattern_;
    int control_count_;
    double size_;
    Vector3 centre_;
    std::vector<LayerTriangle> triangles_; ///< relative to the cage's centre, in units of its size
    std::vector<LayerFace> faces_;         ///< the same, cut into panels
    std::vector<HarmonicData> data_;
    std::vector<Vector3> middles_;
    std::vector<double> reaches_; ///< squared distance from its middle up to which each triangle is near
    // triangles_ and faces_ point to these:
    std::vector<double> corners_;
    std::vector<LayerEdge> edges_;
    std::vector<LayerPanel> panels_;
    std::vector<PackedColumns> flux_;     ///< (unknowns, c) for each triangle
    std::vector<PackedColumns> far_flux_; ///< (3 * triangles, c) for each group of triangles
    double residual_rms_ = 0.0, residual_max_ = 0.0;
};

} // namespace sinew
