// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/handles/constrained_system.h"
#include "native/mesh/regions.h"

#include <vector>

namespace sinew {

/// The precomputed response of a linear surface method to affine motions of its handles.
///
/// M. Botsch, L. Kobbelt. "An Intuitive Framework for Real-Time Freeform Modeling."
/// ACM Transactions on Graphics 23(3), 2004, section 5.
///
/// A handle moved by x -> A x + t displaces its vertices by a linear combination of the four
/// functions x, y, z, 1 of the rest shape, with the entries of (A - I | t) as coefficients. The
/// displacement of the free surface is linear in them, so four basis functions per handle give it all:
///
///     d = B P,    B (n, 4k),    P (4k, 3) the transposed (M_h - I) of all handles, stacked.
///
/// The basis functions that belong to 1 sum to 1 in all parts of the surface that a handle touches.
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
    /// \param response  the response of the surface to columns().
    AffineBasis(const Points& rest, const LinearResponse& response, const Regions& regions);

    /// (n, 4k) B, with four columns per handle, for x, y, z and 1. Every call assembles it again.
    RowMatrix matrix() const;

    /// The same shape and report as the method's solve() from rest.
    /// \param idle_too  whether to write the vertices of parts that no handle touches, which rest.
    /// \throw InvalidConstraint  the number of poses is not k, or one is not finite.
    SolveReport solve(const Poses& poses, Points& positions, bool idle_too = true) const;

private:
    int vertex_count_;
    int columns_; ///< 4k
    std::vector<int> moved_, idle_; ///< vertices of parts that a handle touches, and the others
    Points idle_rest_;
    /// One block per eight of the first, as ProductOfEight reads it: their rest points, then their rows of B.
    std::vector<double> blocks_;
    MatrixX energy_, residual_, load_; ///< (4k, 4k), see LinearResponse
};

} // namespace sinew
