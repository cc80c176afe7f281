// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sinew {

/// A cage in a lattice of cubes: where the lattice's lines cross it, which cubes its triangles touch, and how
/// often it winds around each node. Nodes lie at origin + step * (i, j, k).
class HarmonicLattice
{
public:
    using Node = std::array<int, 3>;

    struct Crossing
    {
        double depth; ///< along its line, in steps from the first node
        int triangle;
        int turn; ///< 1: the line enters the cage here, -1: it leaves
        Vector3 hats;
    };
    struct Hit
    {
        double distance = 0.0;
        int triangle = -1; ///< none
        Vector3 hats = Vector3::Zero();
        Node full{}; ///< the cube's lowest node, where a cube is hit
    };

    /// \param cells  along the longest side of the box around the cage.
    /// \throw OutOfMemory  more than limit_memory() allows.
    HarmonicLattice(const Cage& cage, int cells);

    double step() const { return step_; }
    const Node& size() const { return size_; } ///< nodes along each axis
    std::size_t index(const Node& node) const
    {
        return (static_cast<std::size_t>(node[0]) * size_[1] + node[1]) * size_[2] + node[2];
    }
    /// A node where the winding is 1.
    bool inside(const Node& node) const { return winding_[index(node)] == 1; }

    /// The crossing next to a node, at most `reach` steps up (sign 1) or down (-1) an axis; nullptr for none.
    const Crossing* next(const Node& node, int axis, int sign, double reach) const;

    /// A point in units of the lattice: (point - origin) / step. All functions below take such points as
    /// `at`.
    Vector3 seen(const Vector3& point) const { return (point - origin_) / step_; }
    /// The cube of `width` steps, its lowest node a multiple of it, that holds a point; false outside of the
    /// lattice.
    bool cube(const Vector3& at, int width, Node& lowest) const;
    /// Whether such a cube lies inside, no triangle touching it.
    bool is_full(const Node& lowest, int width) const;

    /// Whether the cage winds around a point once. A point on it may be either.
    bool holds(const Vector3& at) const;
    /// The closest of the triangles within 2 `width` steps; each point inside that is not in a full cube of
    /// that width has one.
    Hit closest(const Vector3& at, int width) const;
    Vector3 on(const Hit& hit) const
    {
        return hit.hats[0] * corner(hit.triangle, 0) + hit.hats[1] * corner(hit.triangle, 1) +
               hit.hats[2] * corner(hit.triangle, 2);
    }
    Vector3 normal(int triangle) const;
    /// From a point inside along a unit vector: up to the first cube of `width` steps that is full, or to the
    /// cage; infinitely far if neither is met.
    Hit march(const Vector3& at, const Vector3& along, int width) const;

private:
    static std::int64_t bytes(const Cage& cage, int cells); ///< the numbers of the nodes included
    bool cross();
    void bin();
    std::span<const int> touching(const Node& cell) const;
    const Vector3& corner(int triangle, int k) const { return points_[triangles_[triangle][k]]; }
    bool is_cell(const Node& cell) const;

    std::vector<Vector3> points_; ///< as seen
    std::vector<Triangle> triangles_;
    Vector3 origin_;
    double step_;
    Node size_;
    std::array<std::vector<int>, 3> first_; ///< of each line along an axis, its crossings
    std::array<std::vector<Crossing>, 3> crossings_;
    std::vector<std::int8_t> winding_;
    std::vector<int> first_in_cell_, in_cell_; ///< triangles
};

} // namespace sinew
