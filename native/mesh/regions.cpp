// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/regions.h"

#include "native/core/errors.h"
#include "native/core/finite.h"

#include <algorithm>
#include <string>
#include <utility>

namespace sinew {

namespace {

std::string name_of(int handle) { return "handle " + std::to_string(handle); }

void check(const Handle& handle, int index, int vertex_count)
{
    using Element = Error::Element;
    if (handle.vertices.empty())
        throw InvalidConstraint(name_of(index) + " has no vertices", Element::handle, {index});
    std::vector<int> outside;
    for (int v : handle.vertices)
        if (v < 0 || v >= vertex_count)
            outside.push_back(v);
    if (!outside.empty())
        throw InvalidConstraint(name_of(index) + ": vertices " + list_some(outside) +
                                    " are out of range [0, " + std::to_string(vertex_count) + ")",
                                Element::handle, {index});
    if (!handle.weights.empty() && handle.weights.size() != handle.vertices.size())
        throw InvalidConstraint(name_of(index) + ": " + std::to_string(handle.weights.size()) +
                                    " weights for " + std::to_string(handle.vertices.size()) + " vertices",
                                Element::handle, {index});
    std::vector<int> bad;
    for (std::size_t k = 0; k < handle.weights.size(); ++k)
        if (!(handle.weights[k] >= 0.0 && handle.weights[k] <= 1.0))
            bad.push_back(handle.vertices[k]);
    if (!bad.empty())
        throw InvalidConstraint(name_of(index) + ": weights outside [0, 1] at vertices " + list_some(bad),
                                Element::vertex, bad);
    if (!(handle.continuity >= 0.0 && handle.continuity <= 2.0))
        throw InvalidConstraint(name_of(index) + ": continuity " + shortest(handle.continuity) +
                                    " is outside [0, 2]",
                                Element::handle, {index});
}

} // namespace

Regions::Regions(std::vector<Handle> handles, const Components& parts) : handles_(std::move(handles))
{
    const int n = static_cast<int>(parts.labels.size());
    hard_.assign(n, -1);
    std::vector<bool> held(parts.count, false);
    std::vector<int> twice;
    int other = -1;
    int second = -1;
    for (int h = 0; h < handle_count(); ++h) {
        const Handle& handle = handles_[h];
        check(handle, h, n);
        for (std::size_t k = 0; k < handle.vertices.size(); ++k) {
            const int v = handle.vertices[k];
            const double weight = handle.weights.empty() ? 1.0 : handle.weights[k];
            if (weight == 0.0)
                continue;
            held[parts.labels[v]] = true;
            if (weight < 1.0) {
                soft_.push_back({v, h, weight});
            } else if (hard_[v] >= 0 && hard_[v] != h) {
                twice.push_back(v);
                other = hard_[v];
                second = h;
            } else {
                hard_[v] = h;
            }
        }
    }
    if (!twice.empty())
        throw InvalidConstraint("vertices " + list_some(twice) + " are held by two handles (" +
                                    std::to_string(other) + " and " + std::to_string(second) +
                                    "); remove them from one, or make one soft",
                                Error::Element::vertex, twice);
    std::erase_if(soft_, [&](const SoftConstraint& s) { return hard_[s.vertex] >= 0; });

    idle_.resize(n);
    for (int v = 0; v < n; ++v)
        idle_[v] = !held[parts.labels[v]];
    idle_parts_ = static_cast<int>(std::ranges::count(held, false));
}

std::vector<Constraint> Regions::constraints() const
{
    std::vector<Constraint> all;
    for (int v = 0; v < vertex_count(); ++v)
        if (hard_[v] >= 0)
            all.push_back({v, hard_[v]});
    for (const SoftConstraint& s : soft_)
        all.push_back({s.vertex, s.handle});
    return all;
}

std::vector<bool> Regions::free_vertices() const
{
    std::vector<bool> free(vertex_count());
    for (int v = 0; v < vertex_count(); ++v)
        free[v] = is_free(v);
    return free;
}

BindReport Regions::report() const
{
    BindReport report;
    report.handle_count = handle_count();
    report.free_parts = idle_parts_;
    std::vector<bool> pulled(vertex_count(), false);
    for (const SoftConstraint& s : soft_)
        pulled[s.vertex] = true;
    for (int v = 0; v < vertex_count(); ++v) {
        report.constrained_vertices += hard_[v] >= 0;
        report.soft_vertices += pulled[v];
        if (idle_[v])
            report.free_vertices.push_back(v);
    }
    return report;
}

void Targets::check(int handle_count) const
{
    if (static_cast<int>(poses.size()) != handle_count)
        throw InvalidConstraint("poses: " + std::to_string(poses.size()) + " given for " +
                                std::to_string(handle_count) + " handles");
    for (int h = 0; h < handle_count; ++h)
        if (!poses[h].allFinite())
            throw InvalidConstraint("poses: NaN or infinite entry in the pose of " + name_of(h),
                                    Error::Element::handle, {h});
    if (from_rest && static_cast<int>(from_rest->size()) != handle_count)
        throw InvalidConstraint("from_rest: " + std::to_string(from_rest->size()) + " flags given for " +
                                std::to_string(handle_count) + " handles");
    if (!incoming)
        return;
    if (incoming->rows() != rest.rows())
        throw InvalidConstraint("incoming: " + std::to_string(incoming->rows()) +
                                " points given for a rest shape of " + std::to_string(rest.rows()));
    std::vector<int> bad;
    for (int v = 0; v < incoming->rows(); ++v)
        if (!incoming->row(v).allFinite())
            bad.push_back(v);
    if (!bad.empty())
        throw InvalidConstraint("incoming: NaN or infinite coordinates at vertices " + list_some(bad),
                                Error::Element::vertex, bad);
}

} // namespace sinew
