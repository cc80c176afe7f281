// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// An edge in the plane of its face: from corner `from` to corner `to`, with direction s, and normal m to the
/// right of s as seen from outside the cage; `offset` = m . corner, `start` = s . corner.
struct LayerEdge
{
    int from, to;
    double sx, sy, mx, my, offset, start, length;
};

/// A triangle with linear flux; its corners are unknowns of the face's flux. Edge k starts at corner k and
/// runs counterclockwise if turn[k] is 1, otherwise backwards. Hat c is the distance from edge c + 1 times
/// inverse_height[c], and slope[c][k] = grad(hat c) . m_k.
struct LayerPanel
{
    int corner[3], edge[3];
    double turn[3];
    double double_area, inverse_height[3], slope[3][3];
};

/// A flat face cut into panels, in the frame of its first corner; n points out of the cage.
struct LayerFace
{
    double origin[3], x[3], y[3], n[3];
    int corners, edges, panels;
    const double* corner; ///< (corners, 2)
    const LayerEdge* edge;
    const LayerPanel* panel;
};

/// A whole triangle of the cage as one panel. Its data are linear, plus multiples of the product of the hats
/// at the ends of edge `diagonal` unless that is -1.
struct LayerTriangle
{
    LayerFace face;
    int diagonal;
    double product;  ///< the product of the gradients of the two hats
    double along[3]; ///< the gradient of the first of them along s_k
};

/// Layer potentials of faces at points, for the kernel 1 / (4 pi r), in closed form. `points` has all x, then
/// all y, then all z, `stride` numbers each; `count` is a multiple of most_layer_points.
///
/// With omega the solid angle, L_k = the integral of 1/r along edge k, R_k that of r, h_k the distance to its
/// line, d the depth below the plane, and hat values lambda_c at the foot of the point:
///   S[1]        = sum_k h_k L_k - d omega
///   S[hat c]    = lambda_c S[1] + sum_k slope_ck R_k
///   D[hat c]    = lambda_c omega - d sum_k slope_ck L_k
/// A point on the face counts as inside the cage. Every variant gives the same bits.
struct LayerKernels
{
    /// out (count, width), with width the number of corners rounded up to a multiple of 4: S of the unknowns
    /// of the face's flux.
    void (*single)(const LayerFace& face, const double* points, int stride, int count, double* out);
    /// out (7, stride): D of the three hats, D of the product, and S of the three hats.
    void (*both)(const LayerTriangle& triangle, const double* points, int stride, int count, double* out);

    static const LayerKernels baseline, avx2, avx512;
};

/// The largest faces that the kernels take.
constexpr int most_layer_corners = 96, most_layer_edges = 256;
/// The largest number of lanes of the kernels.
constexpr int most_layer_points = 8;

} // namespace sinew
