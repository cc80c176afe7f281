// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/regions.h"

#include <vector>

namespace sinew {

/// Displacements that answer columns of constraint values, with inner products of the columns
/// from which the energy and residual of any linear combination follow.
struct LinearResponse
{
    RowMatrix displacement; ///< (n, m)
    MatrixX energy;         ///< (m, m) twice E as a bilinear form, soft terms included
    MatrixX residual;       ///< (m, m) of A d - b on the unknowns
    MatrixX load;           ///< (m, m) of b, the right-hand side
};

/// Precomputed answer of a linear surface method to affine handle motion.
///
/// M. Botsch, L. Kobbelt. "An Intuitive Framework for Real-Time Freeform Modeling."
/// ACM Transactions on Graphics 23(3), 2004, section 5.
///
/// A handle moved by x -> A x + t displaces its vertices by a linear combination of the four
/// functions x, y, z, 1 of the rest shape, with the entries of (A - I | t) as coefficients. The
/// free surface answers linearly, so four basis functions a handle give the whole motion:
///
///     d = B P,    B (n, 4k),    P (4k, 3) the transposed (M_h - I) of all handles, stacked.
///
/// The constant functions of all handles sum to 1 wherever a handle reaches.
///
///   call         repeat it when ...     cost
///   constructor  the factor changed     4k solves, all columns together
///   solve()      the handles moved      one (n, 4k) x (4k, 3) product
class AffineBasis
{
public:
    /// (c, 4k) one row for each of regions.constraints(): x, y, z, 1 of the rest point in the four columns of
    /// its handle.
    static MatrixX columns(const Points& rest, const Regions& regions);

    /// \param rest      (n, 3)
    /// \param response  of the surface to columns().
    AffineBasis(const Points& rest, const LinearResponse& response);

    /// (n, 4k), four columns a handle: the answers to x, y, z and 1 on it. Put together anew each time.
    RowMatrix matrix() const;

    /// The same shape and report as the method's solve() from rest.
    /// \throw InvalidConstraint  the number of poses is not k, or one is not finite.
    SolveReport solve(const Poses& poses, Points& positions) const;

private:
    int vertex_count_;
    int columns_; ///< 4k
    /// Eight vertices a block, as ProductOfEight reads it: their rest points, then B.
    std::vector<double> blocks_;
    MatrixX energy_, residual_, load_; ///< (4k, 4k), see LinearResponse
};

} // namespace sinew
