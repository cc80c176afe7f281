// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/inverse_ffd.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/methods/space/lattice/grid/placing.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr int most_points = 16; ///< along each axis
constexpr double margin = 0.05; ///< of the box, on each side, as a share of its longest side

/// A box around points along the axes of a frame; a side without length gets that of the longest one.
Pose box_along(const SurfaceFrame& frame, const std::vector<Vector3>& points)
{
    Eigen::AlignedBox3d around;
    for (const Vector3& p : points)
        around.extend(frame.in(p));
    const double longest = around.sizes().maxCoeff() > 0.0 ? around.sizes().maxCoeff() : 1.0;
    Pose box;
    for (int axis = 0; axis < 3; ++axis) {
        const double side = around.sizes()[axis] > 1e-6 * longest ? around.sizes()[axis] : longest;
        box.col(axis) = (0.5 * side + margin * longest) * frame.axes.col(axis);
    }
    box.col(3) = frame.out(around.center());
    return box;
}

Pose box_around(const PointsView& points, const Points& handles)
{
    std::vector<Vector3> all;
    for (Eigen::Index i = 0; i < handles.rows(); ++i)
        all.emplace_back(handles.row(i).transpose());
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        all.emplace_back(points.row(i).transpose());
    return box_along(frame_of_points(all, std::vector<double>(all.size(), 1.0)), all);
}

/// The points that lie at exactly the place of an earlier one.
std::vector<int> coinciding(const Points& points)
{
    std::vector<int> order(static_cast<std::size_t>(points.rows())), found;
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int i) { return std::array{points(i, 0), points(i, 1), points(i, 2)}; };
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return key(i) < key(j); });
    for (std::size_t k = 1; k < order.size(); ++k)
        if (key(order[k]) == key(order[k - 1]))
            found.push_back(order[k]);
    std::sort(found.begin(), found.end());
    return found;
}

/// \throw InvalidConstraint  there is none, or one is not finite.
PointsView checked(PointsView handles, const char* name)
{
    if (handles.rows() == 0)
        throw InvalidConstraint("there is no handle: an inverse lattice needs at least one");
    check_pose_of(name, handles, static_cast<int>(handles.rows()));
    return handles;
}

} // namespace

Pose InverseFfd::box_around(const SurfaceMesh& surface)
{
    std::vector<Vector3> corners;
    for (const Triangle& t : surface.triangles())
        for (const int v : t)
            corners.push_back(surface.point(v));
    for (int v = 0; surface.triangles().empty() && v < surface.vertex_count(); ++v)
        corners.push_back(surface.point(v));
    return box_along(surface_frame(surface), corners);
}

InverseFfd::InverseFfd(PointsView handles, const InverseFfdOptions& options)
    : SpaceMethod("handles"), options_(options),
      handles_(checked(handles, control_name()), options.counts, options.weights)
{
    for (int count : options.resolution)
        if (count < 2 || count > most_points)
            throw InvalidOption("resolution: " + std::to_string(count) + " is not between 2 and " +
                                std::to_string(most_points));
    if (!(options.cut_off > 0.0 && options.cut_off < 1.0))
        throw InvalidOption("cut_off must lie between 0 and 1");
    for (int count : options.resolution)
        AxisBasis(options.basis, count, options.degree, LatticeOutside::follow);
}

void InverseFfd::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    const Points& handles = handles_.points();
    const Pose box = options_.frame ? *options_.frame : sinew::box_around(points, handles);
    const auto& n = options_.resolution;
    Points rest(n[0] * n[1] * n[2], 3);
    for (int k = 0, row = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i, ++row)
                rest.row(row) = apply(box, Vector3(2.0 * i / (n[0] - 1.0) - 1.0, 2.0 * j / (n[1] - 1.0) - 1.0,
                                                   2.0 * k / (n[2] - 1.0) - 1.0));
    RestGridOptions of_grid;
    of_grid.basis.fill(options_.basis);
    of_grid.degree = options_.degree;
    auto grid = std::make_shared<const RestGrid>(view(rest), n, of_grid);

    const Eigen::Index count = handles.rows(), controls = rest.rows();
    const Eigen::Index fewer = std::min(count, controls);
    require_memory(static_cast<std::int64_t>(sizeof(double)) * (2 * count * controls + 2 * fewer * fewer),
                   "the inverse of the lattice");
    const VectorX roots = options_.weights.empty()
                              ? VectorX(VectorX::Ones(count))
                              : VectorX(VectorX::Map(options_.weights.data(), count).cwiseSqrt());
    MatrixX B(count, controls); // the rows of constraints that count less are shorter
    for (Eigen::Index c = 0; c < count; ++c)
        B.row(c) = roots[c] * grid->weights(grid->place(handles.row(c).transpose())).transpose();
    progress.tick(0.0, "inverting the lattice");
    // B^+ = B^T (B B^T)^+ = (B^T B)^+ B^T by the eigenvectors of the smaller product, whose eigenvalues are
    // the squares of the singular values.
    const auto [values, vectors] =
        eigenvectors(count <= controls ? product(B, B.transpose()) : transposed_product(B, B));
    const double least = std::max(options_.cut_off * options_.cut_off, 1e-14) * values[fewer - 1];
    const VectorX inverses = (values.array() > least).select(values.cwiseInverse(), 0.0);
    const int rank = static_cast<int>((values.array() > least).count());
    const MatrixX inner = product(vectors * inverses.asDiagonal(), vectors.transpose());
    MatrixX inverse = count <= controls ? transposed_product(B, inner) : product(inner, B.transpose());
    inverse *= roots.asDiagonal();

    std::vector<int> twice = coinciding(handles);
    std::erase_if(twice, [&](int c) { return roots[c] < 1.0; }); // painted regions share points on purpose
    if (!twice.empty())
        report.remarks.push_back(
            "handle points " + list_some(twice) +
            " coincide with others: where they are dragged apart, they meet in the mean");
    PlacedPoints placed = placed_in(*grid, points, report, progress);
    report.weight_bytes = placed.bytes() + static_cast<std::int64_t>(sizeof(double)) * inverse.size();
    grid_ = std::move(grid);
    placed_ = std::move(placed);
    inverse_ = std::move(inverse);
    rank_ = rank;
}

Points InverseFfd::moves_for(PointsView posed) const
{
    check_pose_of(control_name(), posed, handles_.point_count());
    return product(inverse_, MatrixX(posed - handles_.points()));
}

Points InverseFfd::lattice() const
{
    const AccessLock shared = reading();
    return grid_ ? grid_->points() : Points(0, 3);
}

Points InverseFfd::control_moves(PointsView posed) const
{
    const AccessLock shared = reading();
    if (!grid_)
        throw InvalidConstraint("no points are bound to the handles: call bind() first");
    return moves_for(posed);
}

void InverseFfd::displace(PointsView control, PointsView base, PositionsOut out) const
{
    const Points moves = moves_for(control);
    std::visit(
        [&](auto* positions) {
            placed_.blend([&](int cell) { return grid_->cell(cell, moves.data()); }, base, positions);
        },
        out);
}

std::vector<std::string> InverseFfd::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const InverseFfd&>(former);
    const InverseFfdOptions &a = options_, &b = other.options_;
    const bool same = a.resolution == b.resolution && a.basis == b.basis && a.degree == b.degree &&
                      a.cut_off == b.cut_off && a.frame == b.frame;
    const Points &own = handles_.points(), &theirs = other.handles_.points();
    return names_of({{"handles", own.rows() != theirs.rows() || own != theirs || a.weights != b.weights},
                     {"lattice", !same}});
}

void InverseFfd::swap_weights(SpaceMethod& other)
{
    auto& others = static_cast<InverseFfd&>(other);
    std::swap(grid_, others.grid_);
    std::swap(placed_, others.placed_);
    std::swap(inverse_, others.inverse_);
    std::swap(rank_, others.rank_);
}

} // namespace sinew
