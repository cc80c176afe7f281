// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/rows/row_kernels.h"
#include "native/local_global/rows/row_table.h"
#include "native/solvers/single_factor.h"

#include <cstdint>
#include <vector>

namespace sinew {

struct RotationCellsOptions
{
    /// Whether one linear solve moves all rotations together before each is fitted to its own rows. For
    /// tables with pairs only: by fits of single groups, a rotation would spread by one neighbour per
    /// iteration.
    bool field = false;
    int sweeps = 1; ///< how often rotations are moved and fitted per evaluation; with pairs only
    /// Whether groups whose rows share four points are summed up as one quadratic form of these. The energy
    /// is the same, and an evaluation is cheaper.
    bool four_points = true;
};

/// The vectors u and v of a table for one base shape.
struct RotationVectors
{
    std::vector<double> numbers; ///< as RowView::vectors
    std::vector<double> base; ///< (points) in the inner order; only for cells of four points
};

/// What a bind keeps of a table of rows: the rows in the layout of RowKernels, the factor of the Hessian in x
/// on the points that are not held, and with `field` the factor of the rotations' Hessian at rest,
/// M = 2/3 sum_axis U^T W U, on the groups that are not held.
///
/// Points and groups have other numbers inside: the free points come first, in the order in which the factor
/// eliminates them, which keeps neighbours close in memory. The unknowns x of RowProblem have that
/// order.
///
///   call           repeat it when ...              cost
///   constructor    rest, weights or held points    one factorisation, with `field` two
///   set_vectors()  another base shape              O(rows)
class RowSystem
{
public:
    /// \param rest         (points, 3)
    /// \param held_groups  empty where none is held.
    /// \throw FactorizationFailed  a free point hangs in no row; it is named by its number in the table.
    RowSystem(const RowTable& rows, const Points& rest, const std::vector<bool>& held_points,
              const std::vector<bool>& held_groups = {}, const RotationCellsOptions& options = {});

    int point_count() const { return static_cast<int>(order_.size()); }
    int free_count() const { return free_; }
    int group_count() const { return static_cast<int>(group_order_.size()); }
    int row_count() const { return static_cast<int>(weights_.size()); }
    bool has_pairs() const { return has_pairs_; }
    bool has_four_points() const { return !matrices_.empty(); }
    const RotationCellsOptions& options() const { return options_; }

    /// The number in the table of each point and each group; and the inner number of each group.
    const std::vector<int>& order() const { return order_; }
    const std::vector<int>& group_order() const { return group_order_; }
    int inner_group(int group) const { return group_places_[group]; }
    /// (free) the rows of the free points, in the inner order.
    Points free_rows(const PointsView& points) const;

    /// The vectors for another base shape. Those of rows with two rotations stay.
    /// \param base  (points, 3)
    void set_vectors(const PointsView& base, RotationVectors& out) const;
    const RotationVectors& rest_vectors() const { return rest_; }
    /// 1/2 sum w |u|^2 over the rows of one rotation. The rounding error of the energy is proportional to it.
    double scale(const RotationVectors& vectors) const;

    const SingleFactor& position_factor() const { return position_factor_; }
    const SingleFactor& rotation_factor() const { return rotation_factor_; }
    std::int64_t factor_bytes() const { return position_factor_.bytes() + rotation_factor_.bytes(); }
    const std::vector<RowTable::Pull>& pulls() const { return pulls_; } ///< with inner points

    /// Groups [begin, end) whose rotations move, or whose rows only touch points that do, or neither.
    struct Chunk
    {
        int begin, end;
        enum Kind { moving, steady, fixed } kind;
    };
    const std::vector<Chunk>& chunks() const { return chunks_; }
    int moving_groups() const { return moving_; }
    /// The arrays of the table, without points and vectors.
    const RowView& view() const { return view_; }

private:
    void factorize(const RowTable& rows, const std::vector<bool>& held);
    void factorize_field(const RowTable& rows, const Points& rest, const std::vector<bool>& held);
    void number_groups(const RowTable& rows, const std::vector<bool>& held);
    void lay_out(const RowTable& rows);
    bool sum_up(const RowTable& rows);
    void collect_parts();

    RotationCellsOptions options_;
    bool has_pairs_;
    int free_ = 0, moving_ = 0, active_ = 0; ///< groups [moving_, active_) are steady
    std::vector<int> order_, places_, group_order_, group_places_;
    SingleFactor position_factor_, rotation_factor_;
    std::vector<Chunk> chunks_;
    std::vector<int> group_rows_{0}, row_terms_{0}, term_points_, row_groups_, first_turns_, turns_;
    std::vector<double> coefficients_, weights_, fixed_vectors_;
    std::vector<int> parts_{0}, part_forces_, corners_;
    std::vector<double> part_shares_, matrices_;
    std::vector<RowTable::Pull> pulls_;
    RotationVectors rest_;
    RowView view_{};
};

} // namespace sinew
