// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/handles/handle_groups.h"
#include "native/handles/map_blend.h"
#include "native/handles/propagation_kernels.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sinew {

/// t(s): two values or more at even steps from s = 0 to s = 1; straight lines between them and beyond.
class TransferCurve
{
public:
    TransferCurve() = default;
    /// \throw InvalidOption  less than two values, or one that is not finite.
    explicit TransferCurve(const std::vector<double>& values);

    /// Replaces n values of s by t(s).
    void apply(double* s, int n) const
    {
        const int last = static_cast<int>(values_.size()) - 2;
        if (last == 0) {
            const double begin = values_[0], rise = values_[1] - begin;
            for (int i = 0; i < n; ++i)
                s[i] = begin + s[i] * rise;
            return;
        }
        for (int i = 0; i < n; ++i) {
            const double place = s[i] * (last + 1);
            const int k = static_cast<int>(std::clamp(std::floor(place), 0.0, static_cast<double>(last)));
            s[i] = values_[k] + (place - k) * (values_[k + 1] - values_[k]);
        }
    }

private:
    std::vector<double> values_{0.0, 1.0};
};

/// How a handle moves in one frame.
struct HandleMotion
{
    Vector3 centre = Vector3::Zero(), move = Vector3::Zero();
    double turning = 0.0; ///< |R S - I|^2
};

/// Motions of handles, damped and blended at points by their shares t, as
/// methods/surface/linear/propagation.h says.
class PropagatedMotions
{
public:
    /// \param maps     (k) the linear maps of the handles.
    /// \param motions  (k)
    PropagatedMotions(const HandleGroups& groups, std::vector<Matrix3> maps,
                      const std::vector<HandleMotion>& motions);

    int half_turns(const HandleGroups& groups) const { return blend_.half_turns(groups); }

    /// Moves points [begin, end).
    /// \param base    (n, 3)
    /// \param group   group(v), -1 for none: the point stays.
    /// \param held    held(v, place) tells whether a handle holds the point, and its place.
    /// \param shares  shares(v, n, part handle, t) writes t of a part handle of the group of v, for n points
    ///   from v on that
    ///                are in this group.
    /// \param put     put(v, n, places) takes the results of n points from v on.
    template <class Group, class Held, class Shares, class Put>
    void move(int begin, int end, const PointsView& base, const Group& group, const Held& held,
              const Shares& shares, const Put& put) const
    {
        constexpr int most = 256, stride = most + 8; // points of a run, with room for the kernels
        std::vector<double> t(stride * moving_.size()), from(3 * stride), moved(3 * stride);
        const auto alone = [&](int v) {
            const Vector3 place = one(base.row(v).transpose(), group(v), [&](int part_handle) {
                double share = 0.0;
                shares(v, 1, part_handle, &share);
                return share;
            });
            put(v, 1, place.data());
        };
        Vector3 place;
        for (int v = begin; v < end;) {
            const int own = group(v);
            const bool fixed = held(v, place);
            if (fixed || own < 0 || blend_.alike(own)) {
                if (fixed)
                    put(v, 1, place.data());
                else
                    alone(v);
                ++v;
                continue;
            }
            int n = 1;
            while (n < most && v + n < end && group(v + n) == own && !held(v + n, place))
                ++n;
            for (int k = 0; k < parts_[own].count; ++k)
                shares(v, n, part_handles_[begins_[own] + k], &t[k * stride]);
            std::copy_n(base.data() + 3 * v, 3 * n, from.data());
            for (int i = 0; i < n; ++i) {
                const int done =
                    i + kernels_.move(parts_[own], n - i, t.data() + i, stride, &from[3 * i], &moved[3 * i]);
                put(v + i, done - i, &moved[3 * i]);
                i = done;
                if (i < n)
                    alone(v + i);
            }
            v += n;
        }
    }

private:
    using Numbers = Eigen::Matrix<double, 1, MapBlend::numbers>;

    template <class Share>
    Vector3 one(const Vector3& y, int group, const Share& share) const
    {
        if (group < 0)
            return y;
        Numbers nine = Numbers::Map(parts_[group].identity);
        Vector3 centre = Vector3::Zero(), shift = Vector3::Zero();
        double turning = 0.0;
        for (int k = begins_[group]; k < begins_[group] + parts_[group].count; ++k) {
            const double t = share(part_handles_[k]), weight = std::max(0.0, t) * moving_[k].turning;
            nine += t * Numbers::Map(moving_[k].numbers);
            centre += weight * Vector3::Map(moving_[k].centre);
            turning += weight;
            shift += t * Vector3::Map(moving_[k].move);
        }
        const Vector3 arm = turning > 0 ? Vector3(y - centre / turning) : Vector3::Zero();
        return y + (blend_.at(group, nine.data())(arm) - arm) + shift;
    }

    MapBlend blend_;
    const PropagationKernels& kernels_;
    std::vector<PropagatedMotion> moving_; ///< of the handles that move, part after part
    std::vector<int> part_handles_, begins_;
    std::vector<PropagatedPart> parts_;
};

} // namespace sinew
