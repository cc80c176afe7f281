// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/propagated_motions.h"

#include "native/core/errors.h"
#include "native/core/simd/kernel_set.h"

#include <cmath>
#include <utility>

namespace sinew {

namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// The part handles of groups, each with one more at its end, for the identity, which is handle
/// `handle_count`.
HandleGroups with_identity(const HandleGroups& groups, int handle_count)
{
    HandleGroups all;
    for (int g = 0; g < groups.count(); ++g) {
        all.handles.insert(all.handles.end(), groups.handles.begin() + groups.offsets[g],
                           groups.handles.begin() + groups.offsets[g + 1]);
        all.handles.push_back(handle_count);
        all.offsets.push_back(all.part_handle_count());
    }
    return all;
}

MapBlend blend_of(const HandleGroups& groups, std::vector<Matrix3> maps)
{
    const HandleGroups all = with_identity(groups, static_cast<int>(maps.size()));
    maps.emplace_back(Matrix3::Identity());
    return {all, maps};
}

} // namespace

TransferCurve::TransferCurve(const std::vector<double>& values) : values_(values)
{
    if (values.size() < 2 || !std::ranges::all_of(values, [](double value) { return std::isfinite(value); }))
        throw InvalidOption("transfer: give at least two finite values, at even steps from 0 to 1");
}

PropagatedMotions::PropagatedMotions(const HandleGroups& groups, std::vector<Matrix3> maps,
                                     const std::vector<HandleMotion>& motions)
    : blend_(blend_of(groups, std::move(maps))), kernels_(widest_kernels<PropagationKernels>()),
      parts_(groups.count())
{
    const RowMatrix& values = blend_.values();
    for (int group = 0; group < groups.count(); ++group) {
        begins_.push_back(static_cast<int>(moving_.size()));
        // The part handles of the blend are shifted by those of the identity.
        const Numbers identity = values.row(groups.offsets[group + 1] + group);
        Numbers::Map(parts_[group].identity) = identity;
        RowMatrix3::Map(parts_[group].mean) = blend_.mean(group);
        for (int part_handle = groups.offsets[group]; part_handle < groups.offsets[group + 1];
             ++part_handle) {
            const HandleMotion& motion = motions[groups.handles[part_handle]];
            if (motion.turning == 0 && motion.move.isZero(0))
                continue;
            PropagatedMotion& added = moving_.emplace_back();
            Numbers::Map(added.numbers) = values.row(part_handle + group) - identity;
            Vector3::Map(added.centre) = motion.centre;
            Vector3::Map(added.move) = motion.move;
            added.turning = motion.turning;
            part_handles_.push_back(part_handle);
        }
        parts_[group].count = static_cast<int>(moving_.size()) - begins_.back();
    }
    for (int group = 0; group < groups.count(); ++group)
        parts_[group].motions = moving_.data() + begins_[group];
}

} // namespace sinew
