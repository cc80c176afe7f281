// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/multiresolution_space.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/progress_part.h"
#include "native/mesh/components.h"
#include "native/solvers/shared_analyses.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <type_traits>
#include <utility>

namespace sinew {

namespace {

using Place = std::array<double, 3>;

Place place_of(const PointsView& points, Eigen::Index i)
{
    return {points(i, 0), points(i, 1), points(i, 2)};
}

/// The vertex of the mesh that each point is: the one of its number, or the first one at its place.
/// \throw InvalidConstraint  points that are no vertices.
std::vector<int> vertices_of(const SurfaceMesh& mesh, const PointsView& points)
{
    const PointsView vertices = view(mesh.points());
    std::vector<int> found, lost;
    std::map<Place, int> first;
    for (int i = 0; i < points.rows(); ++i) {
        if (i < vertices.rows() && points.row(i) == vertices.row(i)) {
            found.push_back(i);
            continue;
        }
        if (first.empty())
            for (int v = 0; v < vertices.rows(); ++v)
                first.emplace(place_of(vertices, v), v);
        const auto at = first.find(place_of(points, i));
        found.push_back(at == first.end() ? -1 : at->second);
        if (at == first.end())
            lost.push_back(i);
    }
    if (!lost.empty())
        throw InvalidConstraint("points " + list_some(lost) + " are no vertices of the mesh",
                                Error::Element::vertex, lost);
    return found;
}

/// The vertices at handle points, which have no details.
std::vector<Handle> held_vertices(const SurfaceMesh& mesh, const HandlePoints& handles)
{
    std::vector<Place> places;
    const PointsView points = view(handles.points()), vertices = view(mesh.points());
    for (int i = 0; i < points.rows(); ++i)
        places.push_back(place_of(points, i));
    std::ranges::sort(places);
    Handle held;
    for (int v = 0; v < vertices.rows(); ++v)
        if (std::ranges::binary_search(places, place_of(vertices, v)))
            held.vertices.push_back(v);
    return held.vertices.empty() ? std::vector<Handle>{} : std::vector<Handle>{held};
}

struct Frame
{
    std::vector<Points> moved;
    Points detailed;
};

} // namespace

struct MultiresolutionSpace::Binding
{
    DetailBands bands;
    std::vector<int> vertices; ///< of the bound points
    mutable Pool<Frame> frames;
};

MultiresolutionSpace::MultiresolutionSpace(HandlePoints handles, std::shared_ptr<SpaceMethod> base,
                                           const SurfaceMesh& mesh, const MultiresolutionOptions& options)
    : SpaceMethod("handles"), handles_(std::move(handles)), base_(std::move(base)), mesh_(mesh),
      options_(options)
{
    if (!base_)
        throw InvalidOption("base: there is no method to put this one around");
    require_valid(options);
}

MultiresolutionSpace::~MultiresolutionSpace() = default;

void MultiresolutionSpace::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    progress.tick(0.0, "fairing the base");
    auto next = std::make_shared<Binding>();
    next->vertices = vertices_of(mesh_, points);
    const Components parts = connected_components(mesh_);
    const Regions regions(held_vertices(mesh_, handles_), parts);
    const SharedAnalyses shared; // of all bands
    next->bands = DetailBands(mesh_, regions, faired_regions(mesh_, regions, parts), options_,
                              std::make_shared<const RingRotations>(mesh_), part_of(progress, 0.0, 0.5));
    // The base comes last: its own bind leaves it as it was if it throws.
    const SpaceReport of_base =
        base_->rebind(*base_, view(next->bands.levels().back()), part_of(progress, 0.5, 1.0));
    BindReport of_bands;
    next->bands.report(of_bands);
    report.error = of_base.error;
    report.remarks = of_base.remarks;
    std::ranges::copy(of_bands.remarks, std::back_inserter(report.remarks));
    if (of_bands.detail_vectors > 0)
        report.remarks.push_back(std::to_string(of_bands.detail_vectors) +
                                 " details are vectors: no normal of the base leads there");
    report.weight_bytes = of_base.weight_bytes + of_bands.factor_bytes;
    bound_ = std::move(next);
}

void MultiresolutionSpace::displace(PointsView control, PointsView base, PositionsOut out) const
{
    handles_.check(control);
    const bool at_rest = control == view(handles_.control()); // details come back to rounding only
    const auto frame = bound_->frames.take([] { return std::make_unique<Frame>(); });
    if (!at_rest) {
        const std::vector<Points>& levels = bound_->bands.levels();
        frame->moved.resize(levels.size());
        frame->moved.back().resize(levels.back().rows(), 3);
        base_->warp(control, {}, frame->moved.back().data());
        SolveReport report;
        bound_->bands.put_back(levels, frame->moved, true, frame->detailed, report);
    }
    std::visit(
        [&](auto* positions) {
            using Real = std::remove_reference_t<decltype(*positions)>;
            for (Eigen::Index i = 0; i < base.rows(); ++i) {
                const int v = bound_->vertices[static_cast<std::size_t>(i)];
                for (int k = 0; k < 3; ++k)
                    positions[3 * i + k] = static_cast<Real>(
                        at_rest ? base(i, k) : base(i, k) + (frame->detailed(v, k) - mesh_.points()(v, k)));
            }
        },
        out);
}

std::vector<std::string> MultiresolutionSpace::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const MultiresolutionSpace&>(former);
    const bool same_base = base_->can_reuse(*other.base_, view(other.base_->points()));
    return changed(options_, other.options_,
                   names_of({{"handles", !(handles_ == other.handles_)},
                             {"mesh", !(mesh_ == other.mesh_)},
                             {"base", other.bound_ && !same_base}}));
}

void MultiresolutionSpace::swap_weights(SpaceMethod& other)
{
    auto& others = static_cast<MultiresolutionSpace&>(other);
    std::swap(bound_, others.bound_);
    std::swap(base_, others.base_); // they are alike, and their binds go with the rest
}

} // namespace sinew
