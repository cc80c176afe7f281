// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

// The cage as the kernels read it, see CageGeometry. All lengths are in units of its size.

struct CageEdge
{
    int a, b;
    double length;
    double direction[3]; ///< from a to b
};

/// Corner k is opposite side k.
struct CageTriangle
{
    int corners[3], edges[3];
    double normal[3];
    double outward[3][3];     ///< normals of the sides in the plane of the triangle
    double inverse_height[3]; ///< of the heights over the sides
    double cosines[3];        ///< cosines[k]: between the outward normals of the two sides other than k
    double double_area;
    double near; ///< mean value computes T from separate integrals at points nearer to the plane than this
};

struct CageTables
{
    const double* vertices; ///< (vertex_count, 3)
    const CageEdge* edges;
    const CageTriangle* triangles;
    int vertex_count, edge_count, triangle_count;
};

/// The loops of the closed forms for `lanes` points at a time: each entry of an array is `lanes` numbers, one
/// per point. Every variant does the same operations in the same order, fuses none and calls no library, so
/// results agree to the last bit.
struct CageKernels
{
    int lanes;
    /// Mean value weights.
    /// \param points        (3) x, y, z
    /// \param scratch       (4 vertex_count + 2 edge_count) any numbers
    /// \param[out] weights  (vertex_count) the weights, divided by their sum
    /// \param[out] sums     (1) that sum, divided by the sum of the magnitudes of the weights
    /// \param[out] on       the triangle that each point lies on, or -1; one int per point
    void (*mean_value)(const CageTables& cage, const double* points, double* scratch, double* weights,
                       double* sums, int* on);
    /// Green coordinates: phi, psi, and the winding number of the cage around each point.
    /// \param near_edge     (edge_count) any numbers: bit k of what is written there tells whether point k is
    ///                      near the edge
    /// \param[out] phi      (vertex_count)
    /// \param[out] psi      (triangle_count), in units of the cage's size
    /// \param[out] winding  (1)
    /// \return bit k: point k lies on an edge or vertex, and its results have no meaning
    int (*green)(const CageTables& cage, const double* points, double* scratch, int* near_edge, double* phi,
                 double* psi, double* winding);
    /// The integral of the unit direction over a spherical polygon is a sum over the arcs around it. This
    /// computes the contribution of each arc: half its angle, along its unit normal.
    /// \param arcs            (blocks, 6, most_cage_lanes) x, y, z of the first end of each arc, then of the
    ///                        second, as vectors of any length
    /// \param[out] integrals  (blocks, 3, most_cage_lanes)
    void (*arc_integrals)(const double* arcs, int blocks, double* integrals);
    /// Finds out which points lie beyond which of four planes: behind one of the first three, which go
    /// through the origin, or in front of the fourth. A bit is set only if single precision is sure of it.
    /// \param points       (6, count) all x, then all y, then all z of the unit vectors to the points; then
    ///                     the same of the points themselves
    /// \param planes       (4, 4) unit normals and offsets
    /// \param[out] beyond  (count) bits 0 to 3 for the four planes
    void (*beyond_planes)(const float* points, int count, const float* planes, int* beyond);

    static const CageKernels baseline, avx2, avx512;
};

constexpr int most_cage_lanes = 8;

} // namespace sinew
