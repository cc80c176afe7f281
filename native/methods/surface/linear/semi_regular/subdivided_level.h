// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/surface/linear/semi_regular/undone_level.h"
#include "native/solvers/spd_factor.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace sinew {

/// The way between a level y of a semi-regular mesh and its control mesh c, by the rule of subdivision P and
/// details d in frames F of the limit surface, which are built in the same way on both sides [ZSS97]:
///
///     c = argmin |P c - y|^2,    d_i = F_i(P c)^T (y - P c)_i,    x_i = (P c')_i + F_i(P c') d_i.
///
/// So a mesh that was subdivided and not sculpted has no details, and its control mesh is found again. Kept
/// vertices have details, too, because the rules move them. P loses shapes that alternate from vertex to
/// vertex where all have three quads; there c keeps what the kept vertices of y have.
class SubdividedLevel
{
public:
    /// \throw OutOfMemory  the factor of P^T P would take more than limit_memory() allows.
    explicit SubdividedLevel(UndoneLevel level);

    int fine_count() const { return static_cast<int>(level_.rule.rows()); }
    int coarse_count() const { return static_cast<int>(level_.rule.cols()); }
    const std::vector<int>& kept() const { return level_.kept; }
    const SparseRows& rule() const { return level_.rule; }
    const SpdFactor& factor() const { return normal_; }
    std::int64_t bytes() const; ///< with the factor

    /// What the passes below need besides the points. It is kept from call to call.
    struct Workspace
    {
        Points predicted, gap;
        RowMatrix step;
    };

    /// \param y           (fine, 3)
    /// \param[out] c      (coarse, 3)
    /// \param[out] details  (made) one per vertex of the parts that were undone.
    void analyse(const PointsView& y, Points& c, std::vector<Vector3>& details, Workspace& work) const;

    /// \param fallback  (fine) the frame of each vertex where the shape that is made has none there.
    /// \param[out] x    (fine, 3)
    void synthesise(const Points& c, const std::vector<Vector3>& details,
                    const std::function<Matrix3(int vertex)>& fallback, Points& x, Workspace& work) const;

private:
    void predict(const Points& c, Points& x) const;

    UndoneLevel level_;
    SparseMatrix columns_; ///< P, column by column
    SpdFactor normal_;     ///< P^T P
};

} // namespace sinew
