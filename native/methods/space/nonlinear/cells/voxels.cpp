// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/cells/voxels.h"

#include "native/mesh/components.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sinew {

namespace {

constexpr double most_voxels = 1 << 24;
constexpr int tries = 7;
constexpr double close_enough = 0.08; ///< of the wanted number
/// Between a sheet, whose cells are as many as its area asks for, and a solid.
constexpr double dimension = 2.3;
/// Of a side: a face so close to a border touches the cells of both sides, so that rounding decides nothing.
constexpr double border = 1e-6;

/// Whether a triangle touches a box around the origin: there is no axis along which they are apart.
bool touches_box(const Vector3& a, const Vector3& b, const Vector3& c, double half)
{
    const auto apart = [&](const Vector3& axis) {
        const double pa = axis.dot(a), pb = axis.dot(b), pc = axis.dot(c);
        const double reach = half * axis.cwiseAbs().sum();
        return std::min({pa, pb, pc}) > reach || std::max({pa, pb, pc}) < -reach;
    };
    const Vector3 edges[3] = {b - a, c - b, a - c};
    for (int axis = 0; axis < 3; ++axis)
        if (apart(Vector3::Unit(axis)))
            return false;
    if (apart(edges[0].cross(edges[1])))
        return false;
    for (const Vector3& edge : edges)
        for (int axis = 0; axis < 3; ++axis)
            if (apart(edge.cross(Vector3::Unit(axis))))
                return false;
    return true;
}

template <class T>
void add_once(std::vector<T>& to, T value)
{
    if (to.empty() || to.back() != value)
        to.push_back(value);
}

bool have_common(const std::vector<int>& a, const std::vector<int>& b)
{
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
        if (a[i] == b[j])
            return true;
        a[i] < b[j] ? ++i : ++j;
    }
    return false;
}

/// The box around all faces; without any, around all points.
std::pair<Vector3, Vector3> box_of(const SurfaceMesh& mesh)
{
    Eigen::AlignedBox3d box;
    for (const Triangle& t : mesh.triangles())
        for (const int v : t)
            box.extend(mesh.point(v));
    if (box.isEmpty())
        for (int v = 0; v < mesh.vertex_count(); ++v)
            box.extend(mesh.point(v));
    return {box.min(), box.sizes()};
}

/// Which vertices cells have to hold: those of faces, or all if there is no face.
std::vector<char> filled_vertices(const SurfaceMesh& mesh)
{
    std::vector<char> filled(mesh.vertex_count(), mesh.triangles().empty());
    for (const Triangle& t : mesh.triangles())
        for (const int v : t)
            filled[v] = 1;
    return filled;
}

} // namespace

Voxels::Voxels(const SurfaceMesh& mesh, int wanted, int levels, const Progress& progress)
{
    const double longest = std::max(box_of(mesh).second.maxCoeff(), 1e-12);
    double side = longest / std::cbrt(static_cast<double>(wanted)), best = 0.0,
           least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < tries; ++k) {
        progress.tick(0.05 * k, "filling the shape with cells");
        lay_out(mesh, side);
        const double share = fill(mesh, levels) / static_cast<double>(wanted);
        if (std::abs(std::log(share)) < least) {
            least = std::abs(std::log(share));
            best = side_;
        }
        if (std::abs(share - 1.0) < close_enough || side_ > side)
            break;
        side = side_ * std::pow(share, 1.0 / dimension);
    }
    if (side_ != best) {
        lay_out(mesh, best);
        fill(mesh, levels);
    }
}

void Voxels::lay_out(const SurfaceMesh& mesh, double side)
{
    const auto [low, extent] = box_of(mesh);
    const auto size = [&, extent = extent](double s) {
        double product = 1.0;
        for (int axis = 0; axis < 3; ++axis)
            product *= std::floor(extent[axis] / s) + 3.0;
        return product;
    };
    while (size(side) > most_voxels)
        side *= 1.1;
    side_ = side;
    for (int axis = 0; axis < 3; ++axis) {
        dims_[axis] = static_cast<int>(std::floor(extent[axis] / side)) + 3;
        origin_[axis] = low[axis] - 0.5 * (dims_[axis] * side - extent[axis]);
    }
}

template <class Visit>
void Voxels::touched_by(const Vector3& a, const Vector3& b, const Vector3& c, Visit&& visit) const
{
    std::array<int, 3> low{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::clamp(static_cast<int>(std::floor(
                                   (std::min({a[axis], b[axis], c[axis]}) - origin_[axis]) / side_ - border)),
                               0, dims_[axis] - 1);
        high[axis] =
            std::clamp(static_cast<int>(std::floor(
                           (std::max({a[axis], b[axis], c[axis]}) - origin_[axis]) / side_ + border)),
                       0, dims_[axis] - 1);
    }
    const bool single = low == high;
    for (int z = low[2]; z <= high[2]; ++z)
        for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x) {
                const Vector3 centre = origin_ + side_ * Vector3(x + 0.5, y + 0.5, z + 0.5);
                if (single || touches_box(a - centre, b - centre, c - centre, (0.5 + border) * side_))
                    visit(index({x, y, z}));
            }
}

int Voxels::fill(const SurfaceMesh& mesh, int levels)
{
    const std::size_t all = static_cast<std::size_t>(dims_[0]) * dims_[1] * dims_[2];
    state_.assign(all, unknown);
    level_.assign(all, 0);
    slot_.assign(all, -1);
    triangles_.clear();
    parts_.clear();
    const Components components = connected_components(mesh);
    const auto put = [&](std::size_t voxel, int triangle, int part) {
        if (slot_[voxel] < 0) {
            state_[voxel] = shape;
            slot_[voxel] = static_cast<int>(triangles_.size());
            triangles_.emplace_back();
            parts_.emplace_back();
        }
        if (triangle >= 0)
            triangles_[slot_[voxel]].push_back(triangle);
        add_once(parts_[slot_[voxel]], part);
    };
    for (int t = 0; t < static_cast<int>(mesh.triangles().size()); ++t) {
        const auto& [a, b, c] = mesh.triangles()[t];
        touched_by(mesh.point(a), mesh.point(b), mesh.point(c),
                   [&](std::size_t voxel) { put(voxel, t, components.labels[a]); });
    }
    const std::vector<char> filled = filled_vertices(mesh);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (filled[v])
            touched_by(mesh.point(v), mesh.point(v), mesh.point(v),
                       [&](std::size_t voxel) { put(voxel, -1, components.labels[v]); });
    for (std::vector<int>& parts : parts_) {
        std::ranges::sort(parts);
        parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    }

    std::vector<std::size_t> open;
    const auto flood = [&](std::size_t voxel) {
        if (state_[voxel] == unknown) {
            state_[voxel] = empty;
            open.push_back(voxel);
        }
    };
    flood(0); // the border is empty, and connected
    const std::array<std::size_t, 3> steps{1, static_cast<std::size_t>(dims_[0]),
                                           static_cast<std::size_t>(dims_[0]) * dims_[1]};
    while (!open.empty()) {
        const std::size_t voxel = open.back();
        open.pop_back();
        const std::array<std::size_t, 3> at{voxel % steps[1], voxel / steps[1] % dims_[1], voxel / steps[2]};
        for (int axis = 0; axis < 3; ++axis) {
            if (at[axis] > 0)
                flood(voxel - steps[axis]);
            if (at[axis] + 1 < static_cast<std::size_t>(dims_[axis]))
                flood(voxel + steps[axis]);
        }
    }
    for (State& state : state_)
        if (state == unknown)
            state = inner;
    for (int level = 1; level <= levels; ++level)
        merge(level);
    double cubes = 0.0;
    for (std::size_t voxel = 0; voxel < all; ++voxel)
        if (state_[voxel] != empty)
            cubes += std::ldexp(1.0, -3 * level_[voxel]);
    return static_cast<int>(std::lround(cubes));
}

bool Voxels::is_block(const std::array<int, 3>& at, int level) const
{
    const int edge = 1 << level;
    for (int z = -1; z <= edge; ++z)
        for (int y = -1; y <= edge; ++y)
            for (int x = -1; x <= edge; ++x) {
                const std::array<int, 3> voxel{at[0] + x, at[1] + y, at[2] + z};
                for (int axis = 0; axis < 3; ++axis)
                    if (voxel[axis] < 0 || voxel[axis] >= dims_[axis])
                        return false;
                const std::size_t own = index(voxel);
                const bool is_inside = std::min({x, y, z}) >= 0 && std::max({x, y, z}) < edge;
                if (is_inside ? state_[own] != inner || level_[own] != level - 1
                              : state_[own] == empty || level_[own] < level - 1)
                    return false;
            }
    return true;
}

void Voxels::merge(int level)
{
    const int edge = 1 << level;
    std::vector<std::array<int, 3>> blocks;
    for (int z = 0; z + edge <= dims_[2]; z += edge)
        for (int y = 0; y + edge <= dims_[1]; y += edge)
            for (int x = 0; x + edge <= dims_[0]; x += edge)
                if (state_[index({x, y, z})] == inner && is_block({x, y, z}, level))
                    blocks.push_back({x, y, z});
    for (const auto& [x, y, z] : blocks)
        for (int k = 0; k < edge; ++k)
            for (int j = 0; j < edge; ++j)
                for (int i = 0; i < edge; ++i)
                    level_[index({x + i, y + j, z + k})] = static_cast<char>(level);
}

bool Voxels::share_shape(std::size_t one, std::size_t other) const
{
    const int a = slot_[one], b = slot_[other];
    return have_common(triangles_[a], triangles_[b]) || !have_common(parts_[a], parts_[b]);
}

} // namespace sinew
