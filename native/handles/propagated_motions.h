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

    double operator()(double s) const
    {
        const double place = s * static_cast<double>(values_.size() - 1);
        const int last = static_cast<int>(values_.size()) - 2,
                  k = static_cast<int>(std::clamp(std::floor(place), 0.0, static_cast<double>(last)));
        return values_[k] + (place - k) * (values_[k + 1] - values_[k]);
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

/// Motions of handles, damped and blended at points by their shares t, as surface/linear/propagation.h says.
class PropagatedMotions
{
public:
    /// \param maps     (k) the linear maps of the handles.
    /// \param motions  (k)
    PropagatedMotions(const HandleGroups& groups, std::vector<Matrix3> maps,
                      const std::vector<HandleMotion>& motions);

    int half_turns(const HandleGroups& groups) const { return blend_.half_turns(groups); }

    /// Moves points [begin, end).
    /// \param base   (n, 3)
    /// \param group  group(v), -1 for none: the point stays.
    /// \param held   held(v, place) tells whether a handle holds the point, and its place.
    /// \param share  share(v, seat) is t of a seat of the group of v.
    /// \param put    put(v, place) takes the results.
    template <class Group, class Held, class Share, class Put>
    void move(int begin, int end, const PointsView& base, const Group& group, const Held& held,
              const Share& share, const Put& put) const
    {
        std::vector<double> t(4 * moving_.size());
        double from[12], moved[12];
        // Four at once; and one alone as four times the same point, so that it moves the same beside any
        // others.
        const auto by_kernel = [&](int own, const int (&of)[4]) {
            for (int i = 0; i < 4; ++i) {
                Vector3::Map(from + 3 * i) = base.row(of[i]).transpose();
                for (int k = 0; k < parts_[own].count; ++k)
                    t[4 * k + i] = share(of[i], seats_[begins_[own] + k]);
            }
            return kernels_.move(parts_[own], t.data(), from, moved);
        };
        Vector3 place;
        for (int v = begin; v < end; v += 4) {
            const int own = group(v), last = std::min(v + 4, end);
            bool together = last == v + 4 && own >= 0 && !blend_.alike(own);
            for (int i = v; together && i < last; ++i)
                together = group(i) == own && !held(i, place);
            if (together && by_kernel(own, {v, v + 1, v + 2, v + 3})) {
                for (int i = v; i < last; ++i)
                    put(i, Vector3(Vector3::Map(moved + 3 * (i - v))));
                continue;
            }
            for (int i = v; i < last; ++i) {
                const int alone = group(i);
                if (held(i, place))
                    put(i, place);
                else if (alone >= 0 && !blend_.alike(alone) && by_kernel(alone, {i, i, i, i}))
                    put(i, Vector3(Vector3::Map(moved)));
                else
                    put(i, one(base.row(i).transpose(), alone, [&](int seat) { return share(i, seat); }));
            }
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
            const double t = share(seats_[k]), weight = std::max(0.0, t) * moving_[k].turning;
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
    std::vector<int> seats_, begins_;
    std::vector<PropagatedPart> parts_;
};

} // namespace sinew
