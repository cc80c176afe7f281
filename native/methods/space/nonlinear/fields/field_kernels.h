// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sinew {

/// A straight piece of the path of a tool, for times t from 0 to 1: it moves and turns evenly. See
/// VectorField. The lengths `inner` and `outer` change evenly, too.
struct FieldPiece
{
    bool bends; ///< the field of a bend; else that of a drag
    double centre[3], move[3];
    double turn[3];        ///< axis times angle
    // Of a bend: a(t) = cos(angle t) axis + sin(angle t) side, and likewise the axis of the tool itself.
    double axis[3], side[3], own_axis[3], own_side[3];
    double angle, own_angle;
    double width;
    double inner[2], outer[2]; ///< at t = 0, and by how much they grow
};

/// The flow along a piece for `lanes` points at a time. Every variant does the same operations in the same
/// order and fuses none, so results agree to the last bit.
struct FieldKernels
{
    int lanes;
    /// Moves points along the field from t = 0 to 1 by `steps` even steps of a Runge-Kutta rule.
    /// \param order           1 sees the field at the beginning of a step, 2 also in its middle, and 4 also
    /// at
    ///                        its end
    /// \param[in,out] points  (3) x, y, z, each `lanes` numbers
    void (*flow)(const FieldPiece& piece, int steps, int order, double* points);
    /// The same by steps that each point chooses by itself, of at most 1 / least_steps: a step of order 4 is
    /// compared with two of half its length, and repeated with a smaller one while they differ too much.
    /// \param tolerance  a length: the error that is aimed at, at the end of the piece
    void (*flow_to)(const FieldPiece& piece, int least_steps, double tolerance, double* points);
    /// The field at time t.
    /// \param points           (3)
    /// \param[out] velocities  (3)
    void (*velocity)(const FieldPiece& piece, double t, const double* points, double* velocities);

    static const FieldKernels baseline, avx2, avx512;
};

constexpr int most_field_lanes = 16;

} // namespace sinew
