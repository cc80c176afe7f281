// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/surface_mesh.h"

#include "native/core/errors.h"
#include "native/mesh/triangulation.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// Products of four lengths between these, and their inverses, are normal numbers.
constexpr double most = 1e60;
constexpr double least = 1e-60;

void require_measurable(const Points& points)
{
    std::vector<int> bad;
    for (int i = 0; i < points.rows(); ++i)
        if (!points.row(i).allFinite())
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidMesh("points: NaN or infinite coordinates at vertices " + list_some(bad) +
                              "; give finite positions",
                          Error::Element::vertex, bad);
    for (int i = 0; i < points.rows(); ++i)
        if (points.row(i).cwiseAbs().maxCoeff() > most)
            bad.push_back(i);
    if (!bad.empty())
        throw InvalidMesh("points: farther from the origin than 1e60 at vertices " + list_some(bad) +
                              "; use a larger unit of length",
                          Error::Element::vertex, bad);
    const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff();
    if (size > 0.0 && size < least) {
        bad.resize(points.rows());
        std::iota(bad.begin(), bad.end(), 0);
        throw InvalidMesh("points: the mesh is smaller than 1e-60, at vertices " + list_some(bad) +
                              "; use a smaller unit of length",
                          Error::Element::vertex, bad);
    }
}

} // namespace

SurfaceMesh::SurfaceMesh(Points points, std::vector<int> counts, std::vector<int> corners)
    : points_(std::move(points)), corners_(std::move(corners))
{
    const int n = vertex_count();
    if (n == 0)
        throw InvalidMesh("points: the mesh has no vertices");
    require_measurable(points_);

    std::vector<int> small;
    std::int64_t total = 0;
    offsets_.reserve(counts.size() + 1);
    offsets_.push_back(0);
    for (int f = 0; f < static_cast<int>(counts.size()); ++f) {
        if (counts[f] < 3)
            small.push_back(f);
        total += std::max(counts[f], 0);
        offsets_.push_back(static_cast<int>(total));
    }
    if (!small.empty())
        throw InvalidMesh("faces: fewer than three corners in faces " + list_some(small),
                          Error::Element::face, small);
    if (total != static_cast<std::int64_t>(corners_.size()))
        throw InvalidMesh("faces: the corner counts add up to " + std::to_string(total) + ", but " +
                          std::to_string(corners_.size()) + " indices were given");

    std::vector<int> bad;
    for (int f = 0; f < face_count(); ++f)
        if (std::ranges::any_of(face(f), [n](int v) { return v < 0 || v >= n; }))
            bad.push_back(f);
    if (!bad.empty())
        throw InvalidMesh("faces: vertex index out of range [0, " + std::to_string(n) + ") in faces " +
                              list_some(bad),
                          Error::Element::face, bad);

    triangles_.reserve(corners_.size());
    for (int f = 0; f < face_count(); ++f) {
        triangulate(points_, face(f), triangles_);
        triangle_faces_.resize(triangles_.size(), f);
    }
}

namespace {

bool same_bits(const PointsView& a, const PointsView& b)
{
    return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

} // namespace

SurfaceMesh SurfaceMesh::with_points(Points points) const
{
    std::vector<int> counts;
    for (int f = 0; f < face_count(); ++f)
        counts.push_back(static_cast<int>(face(f).size()));
    return {std::move(points), std::move(counts), corners_};
}

bool SurfaceMesh::operator==(const SurfaceMesh& other) const
{
    return corners_ == other.corners_ && offsets_ == other.offsets_ &&
           same_bits(view(points_), view(other.points_));
}

bool SurfaceMesh::is_made_of(const PointsView& points, std::span<const int> counts,
                             std::span<const int> corners) const
{
    if (static_cast<int>(counts.size()) != face_count() || !std::ranges::equal(corners, corners_))
        return false;
    for (int f = 0; f < face_count(); ++f)
        if (counts[f] != offsets_[f + 1] - offsets_[f])
            return false;
    return same_bits(points, view(points_));
}

std::vector<std::array<int, 2>> SurfaceMesh::edges() const
{
    std::vector<std::array<int, 2>> edges;
    edges.reserve(corners_.size());
    for (int f = 0; f < face_count(); ++f) {
        const auto loop = face(f);
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const int a = loop[k];
            const int b = loop[(k + 1) % loop.size()];
            if (a != b)
                edges.push_back({std::min(a, b), std::max(a, b)});
        }
    }
    std::ranges::sort(edges);
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

} // namespace sinew
