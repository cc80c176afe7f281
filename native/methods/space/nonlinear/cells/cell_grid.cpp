// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/cells/cell_grid.h"

#include "native/core/parallel.h"
#include "native/mesh/trees/winding_tree.h"
#include "native/methods/space/nonlinear/cells/voxels.h"
#include "native/methods/space/nonlinear/handles/handle_reach.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace sinew {

namespace {

/// Cells that are more links apart than this do not move each other's points.
constexpr int farthest_link = 8;

/// 1 - 3 r^2 + 2 r^3: 1 at 0, and 0 with its derivative at 1. Neighbours sum to 1.
double falling(double r) { return r < 1.0 ? 1.0 - r * r * (3.0 - 2.0 * r) : 0.0; }

} // namespace

CellGrid::CellGrid(const SurfaceMesh& mesh, int wanted, int levels, const Progress& progress)
{
    const Voxels voxels(mesh, wanted, levels, progress);
    origin_ = voxels.origin();
    side_ = voxels.side();
    dims_ = voxels.dims();
    levels_ = levels;
    has_faces_ = !mesh.triangles().empty();
    make_cells(voxels);
    progress.tick(0.5, "linking cells");
    link(mesh, voxels);
}

void CellGrid::make_cells(const Voxels& voxels)
{
    ids_.assign(voxels.count(), -1);
    voxels.each([&](const std::array<int, 3>& at, std::size_t index) {
        if (!voxels.is_filled(index) || ids_[index] >= 0)
            return;
        const int level = voxels.level(index), edge = 1 << level;
        for (int z = 0; z < edge; ++z)
            for (int y = 0; y < edge; ++y)
                for (int x = 0; x < edge; ++x)
                    ids_[voxels.index({at[0] + x, at[1] + y, at[2] + z})] = size();
        const double half = 0.5 * edge * side_;
        cells_.push_back({origin_ + side_ * Vector3(at[0], at[1], at[2]) + Vector3::Constant(half), half});
        level_of_.push_back(level);
    });
}

void CellGrid::link(const SurfaceMesh& mesh, const Voxels& voxels)
{
    std::optional<WindingTree> winding;
    if (!mesh.triangles().empty()) {
        std::vector<Vector3> points;
        for (int v = 0; v < mesh.vertex_count(); ++v)
            points.push_back(mesh.point(v));
        winding.emplace(points, mesh.triangles());
    }
    std::set<std::array<int, 2>> seen;
    std::vector<CellFace> touching;
    std::vector<std::array<std::size_t, 2>> sides;
    voxels.each([&](const std::array<int, 3>& at, std::size_t index) {
        if (ids_[index] < 0)
            return;
        for (int axis = 0; axis < 3; ++axis) {
            std::array<int, 3> next = at;
            ++next[axis];
            const int a = ids_[index], b = id(next);
            if (b < 0 || a == b || !seen.insert({a, b}).second)
                continue;
            const Cell& smaller = cells_[a].half <= cells_[b].half ? cells_[a] : cells_[b];
            Vector3 middle = smaller.centre;
            middle[axis] = origin_[axis] + side_ * next[axis];
            touching.push_back({{a, b}, smaller.half, middle, axis});
            sides.push_back({index, voxels.index(next)});
        }
    });
    std::vector<char> holds(touching.size(), 0);
    parallel_for(
        static_cast<int>(touching.size()),
        [&](int k) {
            const auto& [one, other] = sides[k];
            holds[k] = !voxels.has_shape(one) || !voxels.has_shape(other) || voxels.share_shape(one, other) ||
                       (winding && winding->at(touching[k].middle) > 0.5);
        },
        64);
    for (std::size_t k = 0; k < touching.size(); ++k)
        if (holds[k])
            faces_.push_back(touching[k]);
}

int CellGrid::id(const std::array<int, 3>& voxel) const
{
    for (int axis = 0; axis < 3; ++axis)
        if (voxel[axis] < 0 || voxel[axis] >= dims_[axis])
            return -1;
    return ids_[(static_cast<std::size_t>(voxel[2]) * dims_[1] + voxel[1]) * dims_[0] + voxel[0]];
}

std::array<int, 3> CellGrid::voxel_of(const Vector3& point) const
{
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
        at[axis] = static_cast<int>(
            std::clamp(std::floor((point[axis] - origin_[axis]) / side_), -1.0, double(dims_[axis])));
    return at;
}

int CellGrid::cell_at(const Vector3& point, bool* inside) const
{
    const int found = id(voxel_of(point));
    if (inside)
        *inside = found >= 0;
    if (found >= 0)
        return found;
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int c = 0; c < size(); ++c)
        if (const double distance = (nearest_in(c, point) - point).squaredNorm(); distance < least) {
            least = distance;
            nearest = c;
        }
    return nearest;
}

Vector3 CellGrid::nearest_in(int cell, const Vector3& point) const
{
    const Vector3 half = Vector3::Constant(cells_[cell].half);
    return point.cwiseMax(cells_[cell].centre - half).cwiseMin(cells_[cell].centre + half);
}

std::vector<int> CellGrid::pieces() const
{
    std::vector<int> piece(static_cast<std::size_t>(size()));
    std::iota(piece.begin(), piece.end(), 0);
    const auto root = [&](int c) {
        while (piece[c] != c)
            c = piece[c] = piece[piece[c]];
        return c;
    };
    for (const CellFace& face : faces_)
        piece[root(face.cell[0])] = root(face.cell[1]);
    for (int c = 0; c < size(); ++c)
        piece[c] = root(c);
    return piece;
}

std::vector<int> CellGrid::join_loose_pieces(const std::vector<char>& held)
{
    while (true) {
        const std::vector<int> piece = pieces();
        std::vector<char> has_handle(piece.size(), 0), tried(piece.size(), 0);
        for (int c = 0; c < size(); ++c)
            has_handle[piece[c]] |= held[c];
        std::vector<int> loose;
        bool joined = false;
        for (int c = 0; c < size() && !joined; ++c)
            if (!has_handle[piece[c]]) {
                loose.push_back(c);
                joined = std::exchange(tried[piece[c]], 1) == 0 && join_to_next(piece, piece[c]);
            }
        if (!joined)
            return loose;
    }
}

bool CellGrid::join_to_next(const std::vector<int>& piece, int loose)
{
    int from = -1, to = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a < size(); ++a)
        for (int b = 0; piece[a] == loose && b < size(); ++b)
            if (piece[b] != loose)
                if (const double distance = (cells_[a].centre - cells_[b].centre).squaredNorm();
                    distance < least) {
                    least = distance;
                    from = a;
                    to = b;
                }
    if (from < 0)
        return false;
    const auto places = [&](int wanted) {
        Points result(std::ranges::count(piece, wanted), 3);
        for (int c = 0, row = 0; c < size(); ++c)
            if (piece[c] == wanted)
                result.row(row++) = cells_[c].centre.transpose();
        return result;
    };
    const double half = std::min(cells_[from].half, cells_[to].half);
    if (has_faces_ && !are_near(std::sqrt(least) - 2.0 * half, places(loose), places(piece[to])))
        return false;
    faces_.push_back({{from, to}, half, 0.5 * (cells_[from].centre + cells_[to].centre), -1});
    return true;
}

std::vector<std::vector<BlendedMaps::Share>> CellGrid::shares(PointsView points,
                                                              std::vector<int>& outside) const
{
    const int count = static_cast<int>(points.rows());
    std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(size()));
    for (const CellFace& face : faces_)
        for (const int side : {0, 1})
            neighbours[face.cell[side]].push_back(face.cell[1 - side]);

    std::vector<int> own(static_cast<std::size_t>(count));
    std::vector<char> is_outside(static_cast<std::size_t>(count), 0);
    parallel_for(
        count,
        [&](int i) {
            bool inside = false;
            own[i] = cell_at(points.row(i).transpose(), &inside);
            is_outside[i] = !inside;
        },
        256);
    for (int i = 0; i < count; ++i)
        if (is_outside[i])
            outside.push_back(i);
    std::vector<std::vector<int>> members(static_cast<std::size_t>(size()));
    for (int i = 0; i < count; ++i)
        members[own[i]].push_back(i);

    std::vector<std::vector<BlendedMaps::Share>> result(static_cast<std::size_t>(count));
    parallel_chunks(size(), 16, [&](int begin, int end) {
        std::vector<int> hops(static_cast<std::size_t>(size()), -1), queue;
        for (int c = begin; c < end; ++c) {
            if (members[c].empty())
                continue;
            queue.assign(1, c);
            hops[c] = 0;
            for (std::size_t k = 0; k < queue.size(); ++k)
                for (const int next : neighbours[queue[k]])
                    if (hops[next] < 0 && hops[queue[k]] < farthest_link) {
                        hops[next] = hops[queue[k]] + 1;
                        queue.push_back(next);
                    }
            for (const int i : members[c]) {
                const Vector3 place = nearest_in(c, points.row(i).transpose());
                std::map<int, double> sums;
                for (int level = 0; level <= levels_; ++level) {
                    const double side = side_ * (1 << level);
                    std::array<int, 3> low{};
                    for (int axis = 0; axis < 3; ++axis)
                        low[axis] = static_cast<int>(std::floor((place[axis] - origin_[axis]) / side - 0.5));
                    for (int corner = 0; corner < 8; ++corner) {
                        std::array<int, 3> voxel{};
                        for (int axis = 0; axis < 3; ++axis)
                            voxel[axis] = (low[axis] + (corner >> axis & 1)) * (1 << level);
                        const int other = id(voxel);
                        if (other < 0 || level_of_[other] != level || hops[other] < 0)
                            continue;
                        const Vector3 r = (place - cells_[other].centre).cwiseAbs() / side;
                        const double weight = falling(r[0]) * falling(r[1]) * falling(r[2]);
                        if (weight > 0.0)
                            sums[other] = weight;
                    }
                }
                for (const auto& [cell, weight] : sums)
                    result[i].push_back({cell, weight});
            }
            for (const int reached : queue)
                hops[reached] = -1;
        }
    });
    return result;
}

} // namespace sinew
