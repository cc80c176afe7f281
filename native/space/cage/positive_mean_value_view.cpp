// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/positive_mean_value_view.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace sinew {

namespace {

using Piece = VisibleCage::Scratch::Piece;

/// The half of a convex polygon before the plane through the apex, and that behind it.
void split(const Piece& piece, const Vector3& normal, Piece& before, Piece& behind)
{
    before.size = behind.size = 0;
    double at[Piece::most + 1];
    for (int i = 0; i < piece.size; ++i)
        at[i] = normal.dot(piece.corner[i]);
    at[piece.size] = at[0];
    for (int i = 0; i < piece.size; ++i) {
        const Vector3& a = piece.corner[i];
        if (at[i] >= 0.0)
            before.add(a);
        if (at[i] <= 0.0)
            behind.add(a);
        if (at[i] * at[i + 1] < 0.0) {
            const Vector3& b = piece.corner[i + 1 < piece.size ? i + 1 : 0];
            const Vector3 crossing = (a * at[i + 1] - b * at[i]) / (at[i + 1] - at[i]);
            before.add(crossing);
            behind.add(crossing);
        }
    }
}

/// The integral of the unit direction over a polygon on the sphere.
Vector3 integral(const Piece& piece)
{
    Vector3 sum = Vector3::Zero();
    for (int i = 0; i < piece.size; ++i) {
        const Vector3& a = piece.corner[i];
        const Vector3& b = piece.corner[i + 1 < piece.size ? i + 1 : 0];
        const Vector3 normal = a.cross(b);
        const double sine = normal.norm();
        if (sine > 1e-300)
            sum += normal * (0.5 * std::atan2(sine, a.dot(b)) / sine);
    }
    return sum;
}

/// Whether a piece lies wholly outside of one of three planes through the apex.
bool beside_one_side(const Piece& piece, const Vector3 (&sides)[3])
{
    for (const Vector3& side : sides) {
        bool outside = true;
        for (int i = 0; i < piece.size && outside; ++i)
            outside = side.dot(piece.corner[i]) <= 0.0;
        if (outside)
            return true;
    }
    return false;
}

bool none_before(const Vector3& normal, const Vector3& a, const Vector3& b, const Vector3& c)
{
    return normal.dot(a) <= 0.0 && normal.dot(b) <= 0.0 && normal.dot(c) <= 0.0;
}

/// The directions that a triangle may be seen in, by the heights of the cap around its corners.
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
    // A spiral of equal areas on one half of the sphere, and its mirror image through the centre.
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

/// Sorts the faces into those that are left and those that are entered, the widest of these first.
void VisibleCage::look(const Vector3& x, Scratch& scratch) const
{
    scratch.left.clear();
    scratch.entered.clear();
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
        const double a = cone.a.norm(), b = cone.b.norm(), c = cone.c.norm();
        cone.narrowness = std::min(
            {cone.a.dot(cone.b) / (a * b), cone.b.dot(cone.c) / (b * c), cone.c.dot(cone.a) / (c * a)});
        if (cone.volume > 0.0) {
            scratch.left.push_back(cone);
        } else if (cone.volume < 0.0) {
            for (Vector3& side : cone.side)
                side = -side;
            scratch.entered.push_back(cone);
        }
    }
    std::stable_sort(scratch.entered.begin(), scratch.entered.end(),
                     [](const Cone& a, const Cone& b) { return a.narrowness < b.narrowness; });

    // Number the vertices of the faces that may hide others.
    scratch.number.assign(vertices_.size(), -1);
    scratch.hiding.clear();
    int count = 0;
    for (const Cone& by : scratch.entered) {
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

/// Sets `beyond`: bit k for vertices beside the face's cone at side k, bit 3 for those behind its plane. Bits
/// are only set where single precision is sure of them, and for the face's own vertices, which lie on the
/// planes. A face whose vertices share a bit hides nothing of this one.
void VisibleCage::sort_vertices(const Cone& face, Scratch& scratch) const
{
    constexpr float sure = 2e-6f;
    const std::size_t count = scratch.beyond.size();
    float n[4][3];
    for (int k = 0; k < 3; ++k) {
        const Vector3 unit = face.side[k].normalized();
        for (int i = 0; i < 3; ++i)
            n[k][i] = static_cast<float>(unit[i]);
    }
    const double length = face.normal.norm();
    for (int i = 0; i < 3; ++i)
        n[3][i] = static_cast<float>(face.normal[i] / length);
    const float plane = static_cast<float>(face.plane / (length * size_));
    const float *ux = scratch.sight.data(), *uy = ux + count, *uz = uy + count;
    const float *px = uz + count, *py = px + count, *pz = py + count;
    int* beyond = scratch.beyond.data();
    for (std::size_t v = 0; v < count; ++v) { // written out, so that it runs on several vertices at once
        const float a = n[0][0] * ux[v] + n[0][1] * uy[v] + n[0][2] * uz[v];
        const float b = n[1][0] * ux[v] + n[1][1] * uy[v] + n[1][2] * uz[v];
        const float c = n[2][0] * ux[v] + n[2][1] * uy[v] + n[2][2] * uz[v];
        const float d = n[3][0] * px[v] + n[3][1] * py[v] + n[3][2] * pz[v] - plane;
        beyond[v] = (a < -sure ? 1 : 0) | (b < -sure ? 2 : 0) | (c < -sure ? 4 : 0) | (d > sure ? 8 : 0);
    }
    for (int k = 0; k < 3; ++k)
        if (const int own = scratch.number[static_cast<std::size_t>(face.vertex[k])]; own >= 0)
            beyond[own] = 15 & ~(1 << k);
}

/// Takes what `by` hides of `face` out of the pieces.
void VisibleCage::hide(const Cone& face, const Cone& by, Scratch& scratch) const
{
    Piece beside[3], turns[2];
    std::vector<Piece>& pieces = scratch.pieces;
    scratch.next.clear(); // what is left of the pieces that are cut
    const bool uncut = pieces.size() == 1 && pieces[0].size == 3; // the whole face: exact() has asked already
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Piece& piece = pieces[i];
        bool hidden = false;
        int cuts = 0;
        if (piece.size + 4 > Piece::most) { // two halves, one after the other
            Piece halves[2];
            for (int k = 0; k <= piece.size / 2; ++k)
                halves[0].add(piece.corner[k]);
            for (int k = piece.size / 2; k <= piece.size; ++k)
                halves[1].add(piece.corner[k % piece.size]);
            for (const Piece& half : halves) {
                Scratch part;
                part.pieces.assign(1, half);
                hide(face, by, part);
                scratch.next.insert(scratch.next.end(), part.pieces.begin(), part.pieces.end());
            }
            hidden = true;
        } else if (uncut || !beside_one_side(piece, by.side)) {
            const Piece* rest = &piece;
            for (int k = 0; k < 3 && rest->size > 2; ++k) {
                split(*rest, by.side[k], turns[k % 2], beside[cuts]);
                cuts += beside[cuts].size > 2;
                rest = &turns[k % 2];
            }
            if (rest->size > 2) { // which of the two is nearer there?
                Vector3 mean = Vector3::Zero();
                for (int k = 0; k < rest->size; ++k)
                    mean += rest->corner[k] / rest->corner[k].lpNorm<1>();
                hidden = by.plane / by.normal.dot(mean) < face.plane / face.normal.dot(mean);
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

void VisibleCage::exact(const Vector3& x, Scratch& scratch, double* row) const
{
    look(x, scratch);
    for (const Cone& face : scratch.left) {
        sort_vertices(face, scratch);
        const int* beyond = scratch.beyond.data();
        Piece whole;
        whole.add(face.a);
        whole.add(face.b);
        whole.add(face.c);
        scratch.pieces.assign(1, whole);
        for (std::size_t k = 0; k < scratch.entered.size(); ++k) {
            const Triangle& corners = scratch.hiding[k];
            if ((beyond[corners[0]] & beyond[corners[1]] & beyond[corners[2]]) != 0)
                continue;
            const Cone& by = scratch.entered[k];
            const bool before = by.normal.dot(face.a) >= by.plane && by.normal.dot(face.b) >= by.plane &&
                                by.normal.dot(face.c) >= by.plane;
            if (before || none_before(by.side[0], face.a, face.b, face.c) ||
                none_before(by.side[1], face.a, face.b, face.c) ||
                none_before(by.side[2], face.a, face.b, face.c))
                continue;
            hide(face, by, scratch);
            if (scratch.pieces.empty())
                break;
        }
        Vector3 sum = Vector3::Zero();
        for (const Piece& piece : scratch.pieces)
            sum += integral(piece);
        for (int k = 0; k < 3; ++k) // negative by rounding alone
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
        // The side of an edge is told by the same numbers in both of its faces, so no ray slips between.
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
