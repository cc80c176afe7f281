// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <span>
#include <vector>

namespace sinew {

/// The table of an energy in which points follow rotations:
///
///     E(x, R) = 1/2 sum_k w_k |sum_i c_ki x_i - R_a u_k - R_b v_k|^2 + 1/2 sum_i s_i |x_i - t_i|^2
///
/// A row follows the rotation of one group or those of two. Points and groups are numbered by the method that
/// fills the table. For fixed rotations the Hessian is the same scalar matrix for x, y and z, whatever the
/// shape.
class RowTable
{
public:
    struct Term
    {
        int point;
        double coefficient;
    };
    struct Row
    {
        double weight;
        int first_term;     ///< up to that of the next row
        int group[2];       ///< a and b, or a and -1
        Vector3 vector[2];  ///< u and v; only where there is b
    };
    struct Pull
    {
        int point;
        double stiffness; ///< s_i
    };

    RowTable(int points, int groups);

    /// A row of one rotation, whose u is the same sum over the base shape: that at rest, or another one that
    /// is handed to a solve.
    /// \param weight  >= 0; a row without weight is left out.
    void add(double weight, std::span<const Term> terms, int group);
    /// A row of two rotations; u and v are fixed.
    void add(double weight, std::span<const Term> terms, int group, const Vector3& u, int other,
             const Vector3& v);
    /// weight |R_a - R_b|^2: three rows that have no points.
    void align(int group, int other, double weight);
    /// 1/2 stiffness |x_i - t_i|^2, where a solve gives t_i.
    void pull(int point, double stiffness) { pulls_.push_back({point, stiffness}); }

    int point_count() const { return points_; }
    int group_count() const { return groups_; }
    /// Whether a row follows two rotations. If not, the best rotations depend on the positions alone, and E
    /// with them is a function of the positions.
    bool has_pairs() const { return has_pairs_; }
    const std::vector<Row>& rows() const { return rows_; }
    std::span<const Term> terms(const Row& row) const
    {
        const bool last = &row == &rows_.back();
        return std::span(terms_).subspan(row.first_term,
                                         (last ? static_cast<int>(terms_.size()) : (&row + 1)->first_term) -
                                             row.first_term);
    }
    const std::vector<Pull>& pulls() const { return pulls_; }

private:
    int points_, groups_;
    bool has_pairs_ = false;
    std::vector<Row> rows_;
    std::vector<Term> terms_;
    std::vector<Pull> pulls_;
};

} // namespace sinew
