// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/solvers/dense/system.h"
#include "native/space/cage/cage.h"
#include "native/space/cage/harmonic/data.h"
#include "native/space/cage/harmonic/layers.h"
#include "native/space/cage/harmonic/pattern.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// Harmonic functions of a cage by boundary elements, one a cage vertex:
///
///     phi_v(x) = S(x) q_v + D(x) g_v
///
/// with the double layer D of the exact data g_v on the cage's faces and the single layer S of the unknown
/// flux q_v on the panels of a HarmonicPattern. q_v solves T S(x_b) q_v = T (g_v - D(x_b)), x_b three points
/// a panel just inside, T the panels' hats times their areas. Constant and linear data have a flux that any
/// pattern holds, so phi sums to one and is linearly precise at any resolution, to the rounding of the
/// solution.
///
/// Flux on triangles farther than some radii from a point is replaced by its linear part, which changes
/// weights by a fraction of the pattern's error and keeps both properties.
class HarmonicBoundary
{
public:
    /// Cost O((triangles * unknowns)^3), and as many numbers squared as memory.
    /// \param level  of harmonic_pattern().
    /// \throw InvalidMesh  triangles of no area, or faces that touch so that the system is singular; named.
    /// \throw OutOfMemory, Cancelled
    HarmonicBoundary(const Cage& cage, int level, const Progress& progress);

    int unknowns() const { return pattern_.unknowns * static_cast<int>(triangles_.size()); }

    /// \param block         (b, 3) points in the frame of the cage.
    /// \param[out] weights  (b, c) phi, as it comes out: slightly negative perhaps.
    /// \param[out] winding  (b) how often the cage winds around each point: 1 inside, 0 outside.
    void evaluate(PointsView block, RowMatrix& weights, std::vector<double>& winding) const;

    /// phi less data at four points a triangle: the root mean of its squares summed over the vertices, and
    /// the largest magnitude. As phi - data is harmonic, its largest magnitude anywhere is on the cage.
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
    int vertex_count_;
    double size_;
    Vector3 centre_;
    std::vector<LayerTriangle> triangles_; ///< in units of the cage's size around its centre
    std::vector<LayerFace> faces_;         ///< the same, cut
    std::vector<HarmonicData> data_;
    std::vector<Vector3> middles_;
    std::vector<double> reaches_; ///< squared distance from its middle up to which a triangle is near
    std::vector<double> corners_; ///< what triangles_ and faces_ point to
    std::vector<LayerEdge> edges_;
    std::vector<LayerPanel> panels_;
    std::vector<PackedColumns> flux_;     ///< (unknowns, c) a triangle
    std::vector<PackedColumns> far_flux_; ///< (3, c) a triangle, for groups of them
    double residual_rms_ = 0.0, residual_max_ = 0.0;
};

} // namespace sinew
