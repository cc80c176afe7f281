// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// A triangle with the half cotangents of its corners: across[k] belongs to corner k and is the weight of the
/// edge opposite to it. With rims, the cell of each corner has all three edges.
struct GraphTriangle
{
    int corner[3];
    double across[3];
};

/// What the kernels read of a ArapSystem. They work on one chunk of nodes at a time, and compute an edge
/// or triangle within the chunk once for all its nodes. Points have three numbers per node; matrices have
/// nine, column after column. The kernels may read one number past the end of either.
struct GraphView
{
    /// The edges of node i to later nodes of its chunk begin at edges[2 i], those to nodes of other chunks at
    /// edges[2 i + 1]; they end at edges[2 i + 2]. `ends` has the node at the other end of each edge.
    const int *edges, *ends;
    const double* weights;   ///< one per edge
    const GraphTriangle* triangles; ///< those that touch the same chunk are neighbours
    bool rims;               ///< whether cells consist of triangles instead of edges
    const double* rigidity;
    int free;                ///< nodes [0, free) have a gradient
    const double *base, *points;
    double smoothing;
};

/// Nodes [begin, end), and with rims the triangles that touch them.
struct GraphChunk
{
    int begin, end;
    int first_triangle, last_triangle;
};

constexpr int graph_chunk = 256; ///< most nodes of a chunk: their covariances fit into the first-level cache
constexpr int covariance_columns = 12; ///< numbers of a covariance: three columns of four lanes each

/// The loops of one evaluation over a chunk. Every variant does the same operations in the same order and
/// fuses none, so results agree to the last bit.
struct ArapKernels
{
    /// S_i = r_i sum over the edges of cell i of w d e^T, with e the edge of the base and d the deformed one.
    /// S begins with that of the first node of the chunk.
    void (*covariances)(const GraphView& view, const GraphChunk& chunk, double* S);
    /// S_i += 2 alpha A sum_j r_ij w_ij R_j
    void (*add_neighbours)(const GraphView& view, const GraphChunk& chunk, const double* R, double* S);
    /// t_i = vee((S_i + 2 alpha A sum_j r_ij w_ij R_j) R_i^T), three numbers each: how strongly cell i and
    /// its neighbours turn R_i. S and t begin with those of the first node of the chunk.
    void (*torques)(const GraphView& view, const GraphChunk& chunk, const double* S, const double* R,
                    double* t);
    /// to_i = turn(omega_i) R_i by Cayley's formula, where |omega| is limited to 1; `to` may be R.
    void (*turn)(const double* omega, const double* R, int count, double* to);
    /// to_i = the rotation closest to S_i + tie |S_i| R_i; safe_i says whether it was found. If not, to_i
    /// stays as it is. `to` may be R.
    void (*fit)(const double* S, const double* R, double tie, int count, double* to, bool* safe);
    /// E of the cells of a chunk. Also writes the gradient of E / energy_factor() at the chunk's free nodes,
    /// to which all cells contribute.
    double (*energy)(const GraphView& view, const GraphChunk& chunk, const double* R, double* gradient);

    static const ArapKernels baseline, avx2;
};

} // namespace sinew
