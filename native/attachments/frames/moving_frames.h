// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/frames/frame_kernels.h"
#include "native/core/simd/aligned.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <vector>

namespace sinew {

/// Patches of a surface before a deformation.
struct FrameRests
{
    AlignedVector<FrameArms> arms; ///< one per slot
    AlignedVector<FourRests> fours;
};

/// Frames that move with patches of a surface: fits of a similarity to each.
///
/// c_t, A_t and n_t are centre, area and unit normal of the patch's triangles at rest, with the weights w_t,
/// and primes mark them after the deformation. With p = sum w c, q = sum w c', rho^2 = sum w |c - p|^2 and
/// N_t = n'_t sqrt(A'_t / A_t),
///
///     C = sum w (c' - q)(c - p)^T / rho^2 + 1/2 sum w N n^T,      R = the rotation closest to C,
///     ln s = max(0, ln s_3 - d) + min(0, ln s_1 + d),             d = (ln s_1 - ln s_3) / 2,
///
/// with the singular values s_1 >= s_2 >= s_3 of C C_rest^+. The normals give C full rank on flat and
/// straight patches. With the anchor sum a c, the frame's map is x -> s R (x - sum a c) + sum a c'. The scale
/// is what all directions have in common, less half their spread: 1 under bending, shear and stretch in one
/// direction, s under a similarity. All of it commutes with similarities, so these are reproduced to
/// rounding.
///
/// Frames are fitted four at a time. Cost: 0.1 us per frame.
class MovingFrames
{
public:
    static constexpr int most_triangles = most_slots; ///< of a patch

    /// \param triangles  1 to 24 of the surface.
    /// \param weights    w, and
    /// \param anchors    a; each sum to 1.
    void add(const std::vector<Triangle>& triangles, const std::vector<double>& weights,
             const std::vector<double>& anchors);
    int size() const { return size_; }
    /// Frame k is lane k % 4 of four k / 4.
    int four_count() const { return static_cast<int>(firsts_.size()) - 1; }

    /// Makes room for the rests of all frames.
    void resize(FrameRests& rests) const;
    /// Measures four frames at rest on these points.
    void measure(int four, const PointsView& points, FrameRests& rests) const;
    /// Fits four frames to these points.
    FourMotions fit(int four, const FrameRests& rests, const PointsView& points) const;
    /// Both at once: from the points `before` to those `after`.
    FourMotions fit(int four, const PointsView& before, const PointsView& after, FourRests& rests) const;

private:
    void measure(int four, const PointsView& points, FrameArms* arms, FourRests& rests) const;
    FourMotions fit(int four, const FrameArms* arms, const FourRests& rests, const PointsView& points) const;

    int size_ = 0;
    AlignedVector<FrameSlot> slots_;
    std::vector<int> firsts_{0}; ///< slots of each four, and the number of all
};

} // namespace sinew
