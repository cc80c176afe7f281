// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/rows/row_table.h"

namespace sinew {

RowTable::RowTable(int points, int groups) : points_(points), groups_(groups) {}

void RowTable::add(double weight, std::span<const Term> terms, int group)
{
    add(weight, terms, group, Vector3::Zero(), -1, Vector3::Zero());
}

void RowTable::add(double weight, std::span<const Term> terms, int group, const Vector3& u, int other,
                   const Vector3& v)
{
    if (!(weight > 0))
        return;
    rows_.push_back({weight, static_cast<int>(terms_.size()), {group, other}, {u, v}});
    terms_.insert(terms_.end(), terms.begin(), terms.end());
    has_pairs_ = has_pairs_ || other >= 0;
}

void RowTable::align(int group, int other, double weight)
{
    for (int axis = 0; axis < 3; ++axis) // |R_a - R_b|^2 is the sum over its columns
        add(2 * weight, {}, group, Vector3::Unit(axis), other, -Vector3::Unit(axis));
}

} // namespace sinew
