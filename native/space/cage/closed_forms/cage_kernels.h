// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

// The cage as the kernels read it: moved to the origin and scaled to size 1, without triangles so thin that
// they have no plane. Lengths are in units of its size.

struct CageEdge
{
    int a, b;
    double length;
    double direction[3]; ///< from a to b
};

/// Corner k lies opposite side k.
struct CageTriangle
{
    int corners[3], edges[3];
    double normal[3];
    double outward[3][3];     ///< normals of the sides, in the plane
    double inverse_height[3]; ///< over side k
    double cosines[3];        ///< of the outward normals but k-th with each other
    double double_area;
    double near; ///< nearer to its plane than this, mean value takes care beyond its sides
};

struct CageTables
{
    const double* vertices; ///< (vertex_count, 3)
    const CageEdge* edges;
    const CageTriangle* triangles;
    int vertex_count, edge_count, triangle_count;
};

/// The loops of the closed forms, `lanes` points at a time: what is told of them holds so many numbers an
/// entry. Every variant does the same operations in the same order, without fused ones, and calls no
/// library: results agree to the last bit.
struct CageKernels
{
    int lanes;
    /// Mean value weights.
    /// \param points        (3) x, y, z
    /// \param scratch       (4 vertex_count + 2 edge_count), whatever stands in them
    /// \param[out] weights  (vertex_count), divided by their sum
    /// \param[out] sums     (1) that sum, divided by the sum of the magnitudes
    /// \param[out] on       the triangle that each point lies on, or -1
    void (*mean_value)(const CageTables& cage, const double* points, double* scratch, double* weights,
                       double* sums, int* on);
    /// Green coordinates: phi, psi, and the winding number of the cage around each point.
    /// \param[out] phi      (vertex_count)
    /// \param[out] psi      (triangle_count), in units of the cage's size
    /// \param[out] winding  (1)
    /// \return bit k: point k lies on an edge or vertex, and what is told of it has no meaning
    int (*green)(const CageTables& cage, const double* points, double* scratch, double* phi, double* psi,
                 double* winding);
    /// What arcs between two directions of any length add to the integral of the unit direction over what
    /// they surround: half their angle along their unit normal.
    /// \param arcs            (blocks, 6, most_cage_lanes) x, y, z of the first direction, then of the second
    /// \param[out] integrals  (blocks, 3, most_cage_lanes)
    void (*arc_integrals)(const double* arcs, int blocks, double* integrals);
    /// Which planes points lie beyond, where single precision is sure of it: behind the first three, which
    /// hold the origin, before the fourth.
    /// \param points       (6, count) all x, then all y, then all z of the unit vectors to the points, then
    /// of
    ///                     the points
    /// \param planes       (4, 4) unit normals and offsets
    /// \param[out] beyond  (count) bits 0 to 3
    void (*beyond_planes)(const float* points, int count, const float* planes, int* beyond);

    static const CageKernels baseline, avx2, avx512;
};

constexpr int most_cage_lanes = 8;

} // namespace sinew
