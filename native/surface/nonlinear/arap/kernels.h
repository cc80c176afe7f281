// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// A triangle with half the cotangents opposite its edges: across[k] belongs to the edge that corner k is not
/// on. With rims each of its corners' cells holds all three edges.
struct ArapTriangle
{
    int corner[3];
    double across[3];
};

/// What the loops over an ArapGraph read. Nodes come in chunks: the loops take one at a time, and an edge or
/// triangle that lies within a chunk is worked out once for all its nodes. Points hold three numbers a node,
/// matrices nine, their three columns; one number more than those may be read.
struct ArapView
{
    /// Edges of node i to later nodes of its chunk from edges[2 i] on, to nodes of other chunks from
    /// edges[2 i + 1] on, up to edges[2 i + 2].
    const int *edges, *ends;
    const double* weights;   ///< one an edge
    const ArapTriangle* triangles; ///< those that touch a chunk stand together
    bool rims;               ///< cells of triangles; else of edges
    const double* rigidity;
    int free;                ///< nodes [0, free) have a gradient
    const double *base, *points;
    double smoothing;
};

/// Nodes [begin, end), and the triangles at them where there are rims.
struct ArapChunk
{
    int begin, end;
    int first_triangle, last_triangle;
};

constexpr int arap_chunk = 256;  ///< nodes at most: their covariances fit a core's first cache
constexpr int arap_columns = 12; ///< numbers of a covariance: its columns, each in four lanes

/// The loops of one evaluation over a chunk. Every variant does the same operations in the same order,
/// without fused ones: results agree to the last bit.
struct ArapKernels
{
    /// S_i = r_i sum over the cell's edges of w p e^T; that of the chunk's first node comes first.
    void (*covariances)(const ArapView& view, const ArapChunk& chunk, double* S);
    /// S_i += 2 alpha A sum_j r_ij w_ij R_j
    void (*add_neighbours)(const ArapView& view, const ArapChunk& chunk, const double* R, double* S);
    /// t_i = vee((S_i + 2 alpha A sum_j r_ij w_ij R_j) R_i^T), three numbers each: how the cell and its
    /// neighbours pull at R_i. Those of the chunk's first node come first in S and t.
    void (*torques)(const ArapView& view, const ArapChunk& chunk, const double* S, const double* R,
                    double* t);
    /// to_i = turn(omega_i) R_i by Cayley's formula, |omega| cut to 1; may be in place.
    void (*turn)(const double* omega, const double* R, int count, double* to);
    /// to_i = the rotation closest to S_i + tie |S_i| R_i; safe_i says where it was found. Where not, to_i
    /// stays as it is. May be in place.
    void (*fit)(const double* S, const double* R, double tie, int count, double* to, bool* safe);
    /// E of the chunk's cells, and what of its gradient belongs to its free nodes.
    double (*energy)(const ArapView& view, const ArapChunk& chunk, const double* R, double* gradient);

    static const ArapKernels baseline, avx2;
};

} // namespace sinew
