// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/visibility/visible_cage.h"

#include "native/core/simd/kernel_set.h"
#include "native/methods/space/cage/closed_forms/cage_kernels.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace sinew {

namespace {

using Piece = VisibleCage::Scratch::Piece;

/// How far the corners of a convex polygon lie in front of each side plane of a cone.
struct Heights
{
    double at[3][Piece::most];
};

/// Splits a polygon along side plane k into the part in front of it, with its heights over the following
/// sides, and the part behind it.
void split(const Piece& piece, const Heights& heights, int k, Piece& before, Heights& before_heights,
           Piece& behind)
{
    const double* at = heights.at[k];
    before.size = behind.size = 0;
    for (int i = 0; i < piece.size; ++i) {
        const int next = i + 1 < piece.size ? i + 1 : 0;
        if (at[i] >= 0.0) {
            for (int j = k + 1; j < 3; ++j)
                before_heights.at[j][before.size] = heights.at[j][i];
            before.add(piece.corner[i]);
        }
        if (at[i] <= 0.0)
            behind.add(piece.corner[i]);
        if (at[i] * at[next] < 0.0) {
            const double scale = 1.0 / (at[next] - at[i]), of_i = at[next] * scale, of_next = -at[i] * scale;
            for (int j = k + 1; j < 3; ++j)
                before_heights.at[j][before.size] = of_i * heights.at[j][i] + of_next * heights.at[j][next];
            const Vector3 crossing = of_i * piece.corner[i] + of_next * piece.corner[next];
            before.add(crossing);
            behind.add(crossing);
        }
    }
}

/// \return false if the whole polygon is behind one of the side planes
bool measure(const Piece& piece, const Vector3 (&sides)[3], Heights& found)
{
    for (int k = 0; k < 3; ++k) {
        bool outside = true;
        for (int i = 0; i < piece.size; ++i) {
            found.at[k][i] = sides[k].dot(piece.corner[i]);
            outside = outside && found.at[k][i] <= 0.0;
        }
        if (outside)
            return false;
    }
    return true;
}

/// Whether a corner lies behind side plane k.
bool is_cut(const Heights& heights, int k, int corners)
{
    return std::any_of(heights.at[k], heights.at[k] + corners, [](double x) { return x < 0.0; });
}

bool none_before(const Vector3& normal, const Vector3& a, const Vector3& b, const Vector3& c)
{
    return normal.dot(a) <= 0.0 && normal.dot(b) <= 0.0 && normal.dot(c) <= 0.0;
}

/// The range of directions in which a triangle may be seen, from the z of the spherical cap around its
/// corners.
std::pair<int, int> heights(const Vector3& a, const Vector3& b, const Vector3& c, int count)
{
    const Vector3 axis = (a + b + c).normalized();
    const double cosine = std::min({axis.dot(a), axis.dot(b), axis.dot(c)});
    if (!(cosine > 0.0))
        return {0, count};
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const double tilt = std::hypot(axis.x(), axis.y());
    const double low = axis.z() < -cosine ? -1.0 : axis.z() * cosine - tilt * sine;
    const double high = axis.z() > cosine ? 1.0 : axis.z() * cosine + tilt * sine;
    return {std::max(0, static_cast<int>(0.5 * count * (low + 1.0)) - 1),
            std::min(count, static_cast<int>(0.5 * count * (high + 1.0)) + 2)};
}

} // namespace

VisibleCage::VisibleCage(const Cage& cage, int directions) : triangles_(cage.triangles()), size_(cage.size())
{
    for (int v = 0; v < cage.vertex_count(); ++v)
        vertices_.push_back(cage.rest().point(v));
    // A spiral that divides one half of the sphere into equal areas, and its mirror image through the centre.
    directions_.resize(3 * static_cast<std::size_t>(directions));
    for (int k = 0; k < directions / 2; ++k) {
        const double z = (2 * k + 1) / static_cast<double>(directions), r = std::sqrt(1.0 - z * z);
        const double turn = (k + 0.5) * std::numbers::pi * (1.0 + std::sqrt(5.0));
        const double at[3] = {r * std::cos(turn), r * std::sin(turn), z};
        for (int axis = 0; axis < 3; ++axis) {
            float* middle = directions_.data() + axis * directions + directions / 2;
            middle[k] = static_cast<float>(at[axis]);
            middle[-1 - k] = -static_cast<float>(at[axis]);
        }
    }
}

VisibleCage::~VisibleCage() = default;

/// Sorts the faces into back faces and front faces.
void VisibleCage::sort_faces(const Vector3& x, Scratch& scratch) const
{
    scratch.back_faces.clear();
    scratch.front_faces.clear();
    for (const Triangle& triangle : triangles_) {
        Cone cone;
        cone.vertex = triangle;
        cone.a = vertices_[triangle[0]] - x;
        cone.b = vertices_[triangle[1]] - x;
        cone.c = vertices_[triangle[2]] - x;
        cone.side[0] = cone.b.cross(cone.c);
        cone.side[1] = cone.c.cross(cone.a);
        cone.side[2] = cone.a.cross(cone.b);
        cone.volume = cone.a.dot(cone.side[0]);
        cone.normal = cone.side[0] + cone.side[1] + cone.side[2];
        cone.plane = cone.normal.dot(cone.a);
        if (cone.volume > 0.0) {
            scratch.back_faces.push_back(cone);
        } else if (cone.volume < 0.0) {
            for (Vector3& side : cone.side)
                side = -side;
            scratch.front_faces.push_back(cone);
        }
    }
    scratch.candidates.resize(scratch.front_faces.size() + 1);

    // The vertices of front faces get numbers.
    scratch.number.assign(vertices_.size(), -1);
    scratch.hiding.clear();
    int count = 0;
    for (const Cone& by : scratch.front_faces) {
        Triangle corners;
        for (std::size_t k = 0; k < 3; ++k) {
            int& number = scratch.number[static_cast<std::size_t>(by.vertex[k])];
            if (number < 0)
                number = count++;
            corners[k] = number;
        }
        scratch.hiding.push_back(corners);
    }
    scratch.beyond.resize(static_cast<std::size_t>(count));
    scratch.sight.resize(6 * static_cast<std::size_t>(count));
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        if (scratch.number[v] < 0)
            continue;
        const Vector3 p = vertices_[v] - x, u = p.normalized();
        for (int k = 0; k < 3; ++k) {
            float* at = scratch.sight.data() + k * count + scratch.number[v];
            at[0] = static_cast<float>(u[k]);
            at[3 * count] = static_cast<float>(p[k] / size_);
        }
    }
}

/// Sets `beyond`: bit k for vertices outside side plane k of the face's cone, bit 3 for those farther away
/// than its plane. Bits are set only if single precision is sure of them, and for the face's own vertices,
/// which lie on the planes. A front face whose three vertices have a bit in common hides nothing of this
/// face.
void VisibleCage::sort_vertices(const Cone& face, Scratch& scratch) const
{
    float planes[4][4];
    for (int k = 0; k < 4; ++k) {
        const Vector3& normal = k < 3 ? face.side[k] : face.normal;
        const double length = normal.norm();
        for (int i = 0; i < 3; ++i)
            planes[k][i] = static_cast<float>(normal[i] / length);
        planes[k][3] = k < 3 ? 0.0f : static_cast<float>(face.plane / (length * size_));
    }
    int* beyond = scratch.beyond.data();
    widest_kernels<CageKernels>().beyond_planes(scratch.sight.data(), static_cast<int>(scratch.beyond.size()),
                                                planes[0], beyond);
    for (int k = 0; k < 3; ++k)
        if (const int own = scratch.number[static_cast<std::size_t>(face.vertex[k])]; own >= 0)
            beyond[own] = 15 & ~(1 << k);
}

/// Removes from the pieces of `face` what `by` hides.
/// \param nearer  whether `by` is known to be nearer wherever both are seen.
void VisibleCage::hide(const Cone& face, const Cone& by, bool nearer, Scratch& scratch) const
{
    Piece beside[3], turns[2];
    Heights heights[3];
    std::vector<Piece>& pieces = scratch.pieces;
    scratch.next.clear(); // the visible parts of the pieces that are cut
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Piece& piece = pieces[i];
        bool hidden = false;
        int cuts = 0;
        if (piece.size + 4 > Piece::most) { // too many corners: both halves are handled separately
            Piece halves[2];
            for (int k = 0; k <= piece.size / 2; ++k)
                halves[0].add(piece.corner[k]);
            for (int k = piece.size / 2; k <= piece.size; ++k)
                halves[1].add(piece.corner[k % piece.size]);
            for (const Piece& half : halves) {
                Scratch part;
                part.pieces.assign(1, half);
                hide(face, by, nearer, part);
                scratch.next.insert(scratch.next.end(), part.pieces.begin(), part.pieces.end());
            }
            hidden = true;
        } else if (measure(piece, by.side, heights[2])) {
            const Piece* rest = &piece;
            const Heights* over = heights + 2;
            for (int k = 0, turn = 0; k < 3 && rest->size > 2; ++k) {
                if (!is_cut(*over, k, rest->size))
                    continue;
                split(*rest, *over, k, turns[turn], heights[turn], beside[cuts]);
                cuts += beside[cuts].size > 2;
                rest = turns + turn;
                over = heights + turn;
                turn = 1 - turn;
            }
            if (rest->size > 2) {
                hidden = nearer;
                if (!hidden) { // which of the two faces is nearer there is found out at the middle
                    Vector3 mean = Vector3::Zero();
                    for (int k = 0; k < rest->size; ++k)
                        mean += rest->corner[k] / rest->corner[k].lpNorm<1>();
                    hidden = by.plane / by.normal.dot(mean) < face.plane / face.normal.dot(mean);
                }
            }
        }
        if (hidden)
            scratch.next.insert(scratch.next.end(), beside, beside + cuts);
        else if (kept++ != i)
            pieces[kept - 1] = piece;
    }
    pieces.resize(kept);
    pieces.insert(pieces.end(), scratch.next.begin(), scratch.next.end());
}

/// Adds the arcs around a polygon to those that the kernel integrates.
void VisibleCage::Scratch::add_arcs(const Piece& piece)
{
    constexpr int width = most_cage_lanes;
    for (int i = 0; i < piece.size; ++i, ++arc_count) {
        if (arc_count % width == 0)
            arcs.resize(arcs.size() + 6 * width); // unused lanes stay zero
        double* const arc = arcs.data() + arc_count / width * 6 * width + arc_count % width;
        const Vector3& a = piece.corner[i];
        const Vector3& b = piece.corner[i + 1 < piece.size ? i + 1 : 0];
        for (int axis = 0; axis < 3; ++axis) {
            arc[axis * width] = a[axis];
            arc[(3 + axis) * width] = b[axis];
        }
    }
}

void VisibleCage::exact(const Vector3& x, Scratch& scratch, double* row) const
{
    sort_faces(x, scratch);
    scratch.arcs.clear();
    scratch.arc_count = 0;
    scratch.last_arcs.clear();
    for (const Cone& face : scratch.back_faces) {
        sort_vertices(face, scratch);
        const int* beyond = scratch.beyond.data();
        Piece whole;
        whole.add(face.a);
        whole.add(face.b);
        whole.add(face.c);
        scratch.pieces.assign(1, whole);
        std::size_t some = 0; // counted without a branch, which the processor could not predict
        for (std::size_t k = 0; k < scratch.hiding.size(); ++k) {
            const Triangle& corners = scratch.hiding[k];
            scratch.candidates[some] = k;
            some += (beyond[corners[0]] & beyond[corners[1]] & beyond[corners[2]]) == 0;
        }
        for (std::size_t k = 0; k < some; ++k) {
            const Cone& by = scratch.front_faces[scratch.candidates[k]];
            const double a = by.normal.dot(face.a) - by.plane, b = by.normal.dot(face.b) - by.plane,
                         c = by.normal.dot(face.c) - by.plane;
            if ((a >= 0.0 && b >= 0.0 && c >= 0.0) || none_before(by.side[0], face.a, face.b, face.c) ||
                none_before(by.side[1], face.a, face.b, face.c) ||
                none_before(by.side[2], face.a, face.b, face.c))
                continue;
            hide(face, by, a < 0.0 && b < 0.0 && c < 0.0, scratch);
            if (scratch.pieces.empty())
                break;
        }
        for (const Piece& piece : scratch.pieces)
            scratch.add_arcs(piece);
        scratch.last_arcs.push_back(scratch.arc_count);
    }

    constexpr int width = most_cage_lanes;
    scratch.integrals.resize(scratch.arcs.size() / 2);
    widest_kernels<CageKernels>().arc_integrals(
        scratch.arcs.data(), static_cast<int>(scratch.arcs.size()) / (6 * width), scratch.integrals.data());
    int arc = 0;
    for (std::size_t f = 0; f < scratch.back_faces.size(); ++f) {
        const Cone& face = scratch.back_faces[f];
        Vector3 sum = Vector3::Zero();
        for (; arc < scratch.last_arcs[f]; ++arc)
            for (int axis = 0; axis < 3; ++axis)
                sum[axis] +=
                    scratch
                        .integrals[static_cast<std::size_t>((arc / width * 3 + axis) * width + arc % width)];
        for (int k = 0; k < 3; ++k) // only rounding makes a weight negative
            row[face.vertex[k]] += std::max(0.0, sum.dot(face.side[k]) / face.volume);
    }
}

void VisibleCage::sampled(const Vector3& x, Scratch& scratch, double* row) const
{
    const int count = static_cast<int>(directions_.size() / 3);
    const float* dx = directions_.data();
    const float* dy = dx + count;
    const float* dz = dy + count;
    scratch.nearest.assign(static_cast<std::size_t>(count), 0.0f);
    scratch.first.assign(static_cast<std::size_t>(count), -1);
    float* nearest = scratch.nearest.data();
    int* first = scratch.first.data();
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const Triangle& triangle = triangles_[t];
        const Vector3 a = vertices_[triangle[0]] - x, b = vertices_[triangle[1]] - x;
        const Vector3 c = vertices_[triangle[2]] - x;
        const Vector3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
        const double volume = a.dot(bc);
        if (!(volume > 0.0))
            continue;
        // Both faces at an edge use the same numbers for it, so no ray passes between them.
        const Eigen::Vector3f p = bc.cast<float>(), q = ca.cast<float>(), r = ab.cast<float>();
        const float inverse = static_cast<float>(1.0 / volume);
        const auto [begin, end] = heights(a.normalized(), b.normalized(), c.normalized(), count);
        for (int i = begin; i < end; ++i) {
            const float u = p[0] * dx[i] + p[1] * dy[i] + p[2] * dz[i];
            const float v = q[0] * dx[i] + q[1] * dy[i] + q[2] * dz[i];
            const float w = r[0] * dx[i] + r[1] * dy[i] + r[2] * dz[i];
            const float near = (u + v + w) * inverse;
            const bool hit = (u >= 0.0f) & (v >= 0.0f) & (w >= 0.0f) & (near > nearest[i]);
            nearest[i] = hit ? near : nearest[i];
            first[i] = hit ? static_cast<int>(t) : first[i];
        }
    }
    for (int i = 0; i < count; ++i) {
        if (first[i] < 0)
            continue;
        const Triangle& triangle = triangles_[static_cast<std::size_t>(first[i])];
        const Vector3 direction(dx[i], dy[i], dz[i]);
        Vector3 u[3];
        for (int k = 0; k < 3; ++k)
            u[k] = vertices_[triangle[k]] - x;
        const double volume = u[0].dot(u[1].cross(u[2]));
        for (int k = 0; k < 3; ++k)
            row[triangle[k]] += std::max(0.0, direction.dot(u[(k + 1) % 3].cross(u[(k + 2) % 3])) / volume);
    }
}

} // namespace sinew
