// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

constexpr int most_slots = 24; ///< of a patch

/// A triangle of each of four patches; one number of four belongs to each patch.
struct FrameSlot
{
    int corners[3][4];
    double weights[4], anchors[4]; ///< w and a of MovingFrames
};

/// What a slot adds to C.
struct FrameArms
{
    double arms[3][4];    ///< w (c - p) / rho^2
    double normals[3][4]; ///< w n / (2 sqrt(2 A))
};

/// Four patches before a deformation.
struct FourRests
{
    double inverse[9][4]; ///< C_rest^+, row by row
    double anchors[3][4]; ///< sum a c
};

/// Where four frames went: x -> scale rotation (x - anchor at rest) + anchor.
struct FourMotions
{
    double rotations[9][4]; ///< row by row
    double scales[4];
    double anchors[3][4];
};

/// x -> A x + t: the columns of A and then t, each filled up with a zero.
struct FrameMap
{
    double columns[4][4];
};

/// Three vertices of a host for each of four loose vertices, and where these are between them.
struct LooseSlot
{
    int vertices[4];
    int corners[3][4];
    double places[3][4]; ///< along two sides of the triangle, and along its normal of length sqrt(2 A)
};

/// The loops of attached parts over a frame of the animation. Every variant does the same operations in the
/// same order and fuses none, so results agree to the last bit. Points are (n, 3) numbers, row by row.
struct FrameKernels
{
    /// Measures four patches at rest, of 1 to 24 slots each. \param[out] C  (9, 4) C_rest, row by row.
    /// \return bit k: whether C_rest of patch k is far enough from singular for the inverse in `rests`.
    int (*measure)(const FrameSlot* slots, int count, const double* points, FrameArms* arms, FourRests& rests,
                   double* C);
    /// Fits four frames. \param[out] C  (9, 4) what the rotations are closest to, row by row.
    /// \return bit k: whether rotation k is there; otherwise C needs a singular value decomposition.
    int (*fit)(const FrameSlot* slots, const FrameArms* arms, int count, const FourRests& rests,
               const double* points, FourMotions& motions, double* C);
    /// Maps some vertices.
    void (*carry)(const FrameMap& map, const int* vertices, int count, const double* from, double* to);
    /// Maps points one after the other.
    void (*carry_row)(const FrameMap& map, int count, const double* from, double* to);
    /// Maps some vertices by sums of maps. Those of vertex i are [offsets[i], offsets[i + 1]).
    void (*bend)(const FrameMap* maps, const int* offsets, const int* frames, const double* shares,
                 const int* vertices, int count, const double* from, double* to);
    /// Finds the places of loose vertices.
    void (*place)(LooseSlot* slots, int count, const double* points);
    /// Moves loose vertices with their triangles. Without `from`, their places are those of place().
    void (*ride)(const LooseSlot* slots, int count, const double* from, double* to);

    static const FrameKernels baseline, avx2;
};

} // namespace sinew
