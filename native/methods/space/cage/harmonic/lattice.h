// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sinew {

/// A cage in a lattice of cubes: where the lines of the lattice cross it, which cubes its triangles touch,
/// and how often it winds around each node. Nodes lie at origin + step * (i, j, k).
class HarmonicLattice
{
public:
    using Node = std::array<int, 3>;

    struct Crossing
    {
        double depth; ///< position along the line, in steps from its first node
        int triangle;
        int turn;     ///< 1 if the line enters the cage here, -1 if it leaves
        Vector3 hats; ///< of the corners of the triangle at the crossing
    };
    struct Hit
    {
        double distance = 0.0;
        int triangle = -1;              ///< the triangle that is hit, or -1
        Vector3 hats = Vector3::Zero(); ///< of the corners of the triangle
        Node full{};                    ///< the lowest node of the cube that is hit, if no triangle is
    };

    /// \param cells  number of cells along the longest side of the box around the cage.
    /// \throw OutOfMemory  this needs more than limit_memory() allows.
    HarmonicLattice(const Cage& cage, int cells);

    double step() const { return step_; }
    const Node& size() const { return size_; } ///< nodes along each axis
    std::size_t index(const Node& node) const
    {
        return (static_cast<std::size_t>(node[0]) * size_[1] + node[1]) * size_[2] + node[2];
    }
    /// Whether the cage winds around a node once.
    bool inside(const Node& node) const { return winding_[index(node)] == 1; }

    /// The next crossing from a node, at most `reach` steps up (sign 1) or down (-1) an axis; null for none.
    const Crossing* next(const Node& node, int axis, int sign, double reach) const;

    /// The coordinates of a point in the lattice, (point - origin) / step.
    Vector3 coordinates(const Vector3& point) const { return (point - origin_) / step_; }

    // All points in what follows are in the coordinates of the lattice.

    /// The cube of `width` steps that contains a point; its lowest node is a multiple of `width`.
    /// \return false outside the lattice
    bool cube(const Vector3& at, int width, Node& lowest) const;
    /// Whether such a cube lies inside the cage and no triangle touches it.
    bool is_full(const Node& lowest, int width) const;

    /// Whether the cage winds around a point once. For a point on the cage the answer may be either.
    bool holds(const Vector3& at) const;
    /// The closest triangle within 2 `width` steps. Each point inside that is not in a full cube of that
    /// width has one.
    Hit closest(const Vector3& at, int width) const;
    Vector3 on(const Hit& hit) const
    {
        return hit.hats[0] * corner(hit.triangle, 0) + hit.hats[1] * corner(hit.triangle, 1) +
               hit.hats[2] * corner(hit.triangle, 2);
    }
    Vector3 normal(int triangle) const;
    /// What a ray from a point inside along a unit vector hits first: a full cube of `width` steps, or the
    /// cage. The distance is infinite if it hits neither.
    Hit march(const Vector3& at, const Vector3& along, int width) const;

private:
    /// The memory of the lattice and of the node numbers of HarmonicMultigrid.
    static std::int64_t bytes(const Cage& cage, int cells);
    bool cross();
    void bin();
    std::span<const int> touching(const Node& cell) const;
    const Vector3& corner(int triangle, int k) const { return points_[triangles_[triangle][k]]; }
    bool is_cell(const Node& cell) const;

    std::vector<Vector3> points_; ///< the cage's vertices in the coordinates of the lattice
    std::vector<Triangle> triangles_;
    Vector3 origin_;
    double step_;
    Node size_;
    std::array<std::vector<int>, 3> first_; ///< where the crossings of each line along an axis begin
    std::array<std::vector<Crossing>, 3> crossings_;
    std::vector<std::int8_t> winding_;
    std::vector<int> first_in_cell_, in_cell_; ///< the triangles that touch each cell
};

} // namespace sinew
