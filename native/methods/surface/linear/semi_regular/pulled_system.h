// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/subdivision/stencils.h"

#include <vector>

namespace sinew {

/// Linear equations for displacements u, some of which are given, while weighted sums of them are pulled:
///
///     E(u) = 1/2 u^T A u + 1/2 sum_i s_i |(S u)_i - r_i|^2    least over the free rows of u
///
///   call         repeat it when ...     cost
///   factorize()  the handles moved over the surface   one factorisation
///   solve()      the handles moved in space           one solve for x, y and z
class PulledSystem
{
public:
    /// \param A          (n, n) symmetric positive semi-definite.
    /// \param S          (pulls, n)
    /// \param stiffness  (pulls) s_i
    /// \param free       (n) whether each row is solved for.
    /// \throw FactorizationFailed  the element of the error is a row.
    void factorize(const SparseMatrix& A, const SparseRows& S, std::vector<double> stiffness,
                   const std::vector<bool>& free);

    /// What is kept from call to call.
    struct Workspace
    {
        RowMatrix b;
        ConstrainedQuadratic::Workspace equations;
    };

    /// \param[in,out] u  (n, 3) the given rows at first, all rows afterwards.
    /// \param pulled     (pulls, 3) r
    SolveReport solve(RowMatrix& u, const Points& pulled, Workspace& work) const;

    bool is_empty() const { return !equations_.problem().matrix; }
    const SpdFactor& factor() const { return equations_.factor(); }

private:
    std::vector<double> stiffness_;
    SparseMatrix pulls_; ///< (pulls, n) S, column by column
    ConstrainedQuadratic equations_;
};

/// (n, n) A of a thin plate, L M^-1 L with cotangents and areas.
SparseMatrix plate_energy(const SurfaceMesh& mesh);

} // namespace sinew
