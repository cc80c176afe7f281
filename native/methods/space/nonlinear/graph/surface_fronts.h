// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace sinew {

/// The lengths of a surface that fronts of distances along it need, in single precision: nothing else of the
/// shape counts, so that a turn of the axes changes their last bits at most. 32 bytes per corner of a
/// triangle.
class SurfaceFronts
{
public:
    static constexpr float infinite = std::numeric_limits<float>::infinity();

    /// \param mesh  of about unit size.
    explicit SurfaceFronts(const SurfaceMesh& mesh);

    int size() const { return static_cast<int>(offsets_.size()) - 1; }
    /// Twice the longest edge at a vertex. A front that is to be right as far as a bound b at every vertex
    /// has to run to b + margin: the vertices across the edges of those before the bound are not farther.
    float margin(int vertex) const { return margins_[vertex]; }

    class Front;

private:
    /// A triangle, as seen from one of its corners. For each of the other two: where it is along the edge
    /// from this corner to the third one, and how far beside.
    struct Wedge
    {
        std::array<int, 2> to;
        std::array<float, 2> length, along, height;
    };

    std::vector<int> offsets_;
    std::vector<Wedge> wedges_; ///< of each vertex
    std::vector<float> margins_;
};

/// Distances along the surface from one vertex at a time.
///
/// A front is taken as that of a point in the plane of each triangle, which is exact where the surface
/// unfolds into a plane (M. Novotni, R. Klein, "Computing Geodesic Distances on Triangular Meshes", WSCG
/// 2002).
class SurfaceFronts::Front
{
public:
    explicit Front(const SurfaceFronts& surface)
        : surface_(surface), distance_(static_cast<std::size_t>(surface.size()), infinite),
          times_(distance_.size(), 0)
    {
    }

    /// Calls visit(vertex, distance) for the vertices nearer to `source` than bound(vertex), in no order.
    template <class Bound, class Visit>
    void from(int source, Bound&& bound, Visit&& visit)
    {
        reached_.clear();
        offer(source, 0.0F, bound);
        while (!open_.empty()) {
            std::ranges::pop_heap(open_, std::greater{});
            const auto v = static_cast<int>(open_.back() & 0xFFFFFFFFU);
            const auto distance = std::bit_cast<float>(static_cast<std::uint32_t>(open_.back() >> 32U));
            open_.pop_back();
            if (distance > distance_[v])
                continue;
            for (int k = surface_.offsets_[v]; k < surface_.offsets_[v + 1]; ++k) {
                const Wedge& wedge = surface_.wedges_[k];
                offer(wedge.to[0], past(wedge, 0, distance), bound);
                offer(wedge.to[1], past(wedge, 1, distance), bound);
            }
        }
        for (const int v : reached_) {
            visit(v, distance_[v]);
            distance_[v] = infinite;
        }
    }

private:
    /// The least share by which a distance has to become shorter. Among slivers, each gain sets off others,
    /// so it doubles with every `patience` offers.
    static constexpr float least_gain = 1e-5F;
    static constexpr int patience = 8;

    template <class Bound>
    void offer(int v, float distance, Bound&& bound)
    {
        if (distance_[v] == infinite) {
            if (!(distance < bound(v)))
                return;
            reached_.push_back(v);
            times_[v] = 0;
        } else {
            if (!(distance < distance_[v]) ||
                !(distance < distance_[v] * (1.0F - std::ldexp(least_gain, times_[v]++ / patience))))
                return;
        }
        distance_[v] = distance;
        open_.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32U |
                        static_cast<std::uint32_t>(v));
        std::ranges::push_heap(open_, std::greater{});
    }

    /// How far one of the other corners is, by the edge to it or across the triangle.
    float past(const Wedge& wedge, int k, float at) const
    {
        const float straight = at + wedge.length[k], at_other = distance_[wedge.to[1 - k]];
        if (at_other == infinite)
            return straight;
        // Of the point in the plane that is as far from both ends of the edge as they say.
        const float length = wedge.length[1 - k];
        const float source = 0.5F * (length + (at - at_other) * (at + at_other) / length);
        const float depth = std::sqrt(std::max(0.0F, (at - source) * (at + source)));
        const float beside = depth + wedge.height[k];
        const float crossing = source * wedge.height[k] + wedge.along[k] * depth;
        if (!(crossing > 0.0F && crossing < length * beside))
            return straight; // the way to it does not cross the edge; or the triangle has no size
        const float aside = wedge.along[k] - source;
        return std::min(straight, std::sqrt(aside * aside + beside * beside));
    }

    const SurfaceFronts& surface_;
    std::vector<float> distance_;
    std::vector<int> times_; ///< that a shorter way to each vertex was offered
    std::vector<int> reached_;
    /// A heap of vertices, with their distances in the upper bits: those of numbers >= 0 are ordered as
    /// these.
    std::vector<std::uint64_t> open_;
};

} // namespace sinew
