// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"

namespace sinew {

/// How the details of one band are stored, and put back on a base that moved.
///
/// A coding is bound to the band of the rest shape by its constructor. In a frame, the shapes of the band may
/// be others than at rest, where a shape enters. If the base does not move, the fine shape comes back to
/// rounding, and if it moves rigidly, the fine shape moves with it.
class DetailCoding
{
public:
    /// One band in one frame, (n, 3) each: the fine and the coarse shape before the deformation, and the
    /// coarse one after it.
    struct Band
    {
        PointsView fine, coarse, moved;
        bool at_rest = false; ///< whether fine and coarse are those of the rest shape
    };

    DetailCoding() = default;
    virtual ~DetailCoding() = default;
    DetailCoding(const DetailCoding&) = delete;
    DetailCoding& operator=(const DetailCoding&) = delete;

    /// Safe from several threads at once.
    /// \param[out] detailed    (n, 3) the fine shape after the deformation.
    /// \param[in,out] report   is completed by what this took.
    virtual void apply(const Band& band, Points& detailed, SolveReport& report) const = 0;

    /// Tells the counts of factorisations and the memory, where there is a factor.
    virtual void report(BindReport& /*report*/) const {}

    /// How many details are vectors, because this coding has none for them.
    virtual int vectors() const { return 0; }
};

} // namespace sinew
