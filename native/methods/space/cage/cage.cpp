// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// The vertices, ascending, of the edges along which faces run more often in one direction than in the other.
std::vector<int> unbalanced_vertices(const SurfaceMesh& mesh)
{
    struct Side
    {
        int low, high, balance;
    };
    std::vector<Side> sides;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const std::span<const int> face = mesh.face(f);
        for (std::size_t i = 0; i < face.size(); ++i) {
            const int a = face[i], b = face[(i + 1) % face.size()];
            sides.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    });
    std::vector<int> found;
    for (std::size_t i = 0; i < sides.size();) {
        int balance = 0;
        std::size_t j = i;
        for (; j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high; ++j)
            balance += sides[j].balance;
        if (balance != 0)
            found.insert(found.end(), {sides[i].low, sides[i].high});
        i = j;
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

double volume(const SurfaceMesh& mesh)
{
    const Vector3 origin = mesh.point(0);
    double six = 0.0;
    for (const Triangle& t : mesh.triangles())
        six += (mesh.point(t[0]) - origin).cross(mesh.point(t[1]) - origin).dot(mesh.point(t[2]) - origin);
    return six / 6.0;
}

} // namespace

Cage::Cage(SurfaceMesh rest, bool may_be_flat, const CageSmoothing& smoothing)
    : smoothing_((require_valid(smoothing), smoothing)), frame_(rest.points()), rest_(frame_.in(rest)),
      smooth_(smoothing.smooth != CageSmooth::off && rest.face_count() > 0
                  ? std::make_shared<const SmoothCage>(rest_, smoothing)
                  : nullptr)
{
    if (smooth_) {
        control_ = rest_.points();
        rest_ = smooth_->mesh(view(control_));
    }
    size_ = (rest_.points().colwise().maxCoeff() - rest_.points().colwise().minCoeff()).norm();
    if (smooth_ || !frame_.is_identity())
        given_ = std::move(rest);
    if (rest_.face_count() == 0)
        throw InvalidMesh("the cage has no faces");
    std::vector<int> all(static_cast<std::size_t>(given().face_count()));
    std::iota(all.begin(), all.end(), 0);
    outline_ = flat_outline(rest_);
    if (outline_ && !may_be_flat)
        throw InvalidMesh("the cage is flat: mean value and Green coordinates take flat cages, other methods "
                          "need one that encloses a volume",
                          Error::Element::face, std::move(all));
    if (outline_)
        return;
    const std::vector<int> unbalanced = unbalanced_vertices(given());
    if (!unbalanced.empty())
        throw InvalidMesh("the cage is open, or neighbouring faces look to different sides, at vertices " +
                              list_some(unbalanced) + ": close it and recalculate its normals",
                          Error::Element::vertex, unbalanced);
    // Due to rounding, a flat cage may have a volume of some 1e-16 of the cube of its size.
    if (const double enclosed = volume(rest_); !(enclosed > 1e-14 * size_ * size_ * size_)) {
        throw InvalidMesh(enclosed < -1e-14 * size_ * size_ * size_ ? "the cage is inside out: flip its faces"
                                                                    : "the cage encloses no volume",
                          Error::Element::face, std::move(all));
    }
}

PointsView Cage::refined(PointsView control, Points& storage) const
{
    if (!smooth_)
        return control;
    storage = smooth_->refined(control);
    return view(storage);
}

std::optional<SurfaceMesh> Cage::smooth_mesh() const
{
    return smooth_ ? std::optional(smooth_->mesh(view(given().points()))) : std::nullopt;
}

void Cage::check_pose(PointsView vertices) const
{
    if (vertices.rows() != control_count())
        throw InvalidConstraint("the cage was bound with " + std::to_string(control_count()) +
                                " vertices, and posed with " + std::to_string(vertices.rows()) +
                                ": bind again");
    std::vector<int> bad;
    for (int v = 0; v < control_count(); ++v)
        if (!vertices.row(v).allFinite())
            bad.push_back(v);
    if (!bad.empty())
        throw InvalidConstraint("cage vertices " + list_some(bad) + " are not finite", Error::Element::vertex,
                                bad);
}

} // namespace sinew
