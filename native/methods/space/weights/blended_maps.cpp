// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/blended_maps.h"

#include "native/core/parallel.h"

#include <algorithm>
#include <array>

namespace sinew {

void BlendedMaps::add(const std::vector<Share>& shares)
{
    double sum = 0.0;
    std::size_t largest = 0;
    for (std::size_t k = 0; k < shares.size(); ++k) {
        sum += shares[k].weight;
        if (shares[k].weight > shares[largest].weight)
            largest = k;
    }
    // The largest weight takes what rounding the others leaves. It is read as 1 less the others, see apply().
    maps_.push_back(shares[largest].map);
    weights_.push_back(static_cast<float>(shares[largest].weight / sum));
    for (std::size_t k = 0; k < shares.size(); ++k)
        if (k != largest && shares[k].weight > 0.0) {
            maps_.push_back(shares[k].map);
            weights_.push_back(static_cast<float>(shares[k].weight / sum));
        }
    offsets_.push_back(static_cast<int>(maps_.size()));
}

std::int64_t BlendedMaps::bytes() const
{
    return static_cast<std::int64_t>(sizeof(int) * (offsets_.size() + maps_.size()) +
                                     sizeof(float) * weights_.size());
}

std::vector<BlendedMaps::Share> BlendedMaps::shares(int point) const
{
    std::vector<Share> result;
    double rest = 1.0;
    for (int k = offsets_[point] + 1; k < offsets_[point + 1]; ++k) {
        result.push_back({maps_[k], static_cast<double>(weights_[k])});
        rest -= weights_[k];
    }
    result.insert(result.begin(), {maps_[offsets_[point]], rest});
    return result;
}

template <class Real>
void BlendedMaps::apply(const Poses& maps, const Vector3& centre, PointsView at, PointsView base,
                        Real* out) const
{
    parallel_for(point_count(), [&](int i) {
        const int first = offsets_[i], end = offsets_[i + 1];
        const double* const own = maps[maps_[first]].data();
        std::array<double, 12> D{};
        for (int k = first + 1; k < end; ++k) {
            const double weight = weights_[k];
            const double* const other = maps[maps_[k]].data();
            for (int c = 0; c < 12; ++c)
                D[c] += weight * (other[c] - own[c]);
        }
        const double x = at(i, 0) - centre[0], y = at(i, 1) - centre[1], z = at(i, 2) - centre[2];
        for (int axis = 0; axis < 3; ++axis) {
            const double* const d = own + 4 * axis;
            const double* const b = D.data() + 4 * axis;
            const double move = (d[0] + b[0]) * x + (d[1] + b[1]) * y + (d[2] + b[2]) * z + (d[3] + b[3]);
            out[3 * static_cast<std::size_t>(i) + axis] = static_cast<Real>(base(i, axis) + move);
        }
    });
}

template void BlendedMaps::apply(const Poses&, const Vector3&, PointsView, PointsView, double*) const;
template void BlendedMaps::apply(const Poses&, const Vector3&, PointsView, PointsView, float*) const;

} // namespace sinew
