// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <vector>

namespace sinew {

/// Where a frame went: x -> exp(log_scale) rotation (x - origin) + place.
struct FrameMotion
{
    Matrix3 rotation;
    double log_scale;
    Vector3 origin, place;
};

/// The surface beneath a frame before a deformation, and where the frame sits in its part.
struct FrameRest;

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
/// straight patches. A frame that sat at o is then at sum a c' + s R (o - sum a c). The scale is what all
/// directions have in common, less half their spread: 1 under bending, shear and stretch in one direction, s
/// under a similarity. All of it commutes with similarities, so these are reproduced to rounding.
class MovingFrames
{
public:
    static constexpr int most_triangles = 24; ///< of a patch

    /// \param triangles  1 to 24 of the surface.
    /// \param weights    w, and
    /// \param anchors    a; each sum to 1.
    void add(const std::vector<Triangle>& triangles, const std::vector<double>& weights,
             const std::vector<double>& anchors);
    int size() const { return static_cast<int>(patches_.size()); }

    /// Measures the rest of a frame on these points; `origin` is where it sits then.
    FrameRest rest(int frame, const PointsView& points, const Vector3& origin) const;
    FrameMotion move(int frame, const FrameRest& rest, const PointsView& points) const;

private:
    /// Filled up with the first triangle at weight 0, so that all loops have the same length.
    struct Slots
    {
        std::array<std::array<int, most_triangles>, 3> corners;
        std::array<double, most_triangles> weights, anchors;
    };
    std::vector<Slots> patches_;
};

struct FrameRest
{
    using Numbers = std::array<double, MovingFrames::most_triangles>;

    std::array<Numbers, 3> arms;    ///< w (c - p) / rho^2
    std::array<Numbers, 3> normals; ///< w n / 2
    Numbers areas;                  ///< 2 A
    Matrix3 inverse;                ///< C_rest^+
    Vector3 anchor, origin;         ///< sum a c, and where the frame sits
};

} // namespace sinew
