// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/simd/aligned.h"
#include "native/methods/space/cage/cage.h"

#include <vector>

namespace sinew {

/// The part of a cage that points inside it can see, and the mean value integrals over that part.
///
/// From inside, a point sees the backs of faces. A face whose front looks towards the point may hide such a
/// back face. The cone of each back face is cut by the side planes of the front faces that hide it. The
/// integral of the unit direction over a spherical polygon is half the sum of arc angle times arc normal. The
/// integral over the visible pieces of a triangle is divided among its corners, so that sum_i w_i (v_i - x)
/// is the integral.
class VisibleCage
{
public:
    /// \param directions  number of rays for sampled(), in antipodal pairs; 0 for none.
    VisibleCage(const Cage& cage, int directions);
    ~VisibleCage();

    bool has_directions() const { return !directions_.empty(); }

    struct Scratch; ///< memory of one thread
    /// Adds the weights of a point x, not divided by their sum, to row (c). x is inside and not on the cage.
    void exact(const Vector3& x, Scratch& scratch, double* row) const;
    /// The same by rays.
    void sampled(const Vector3& x, Scratch& scratch, double* row) const;

private:
    struct Cone;

    void sort_faces(const Vector3& x, Scratch& scratch) const;
    void sort_vertices(const Cone& face, Scratch& scratch) const;
    void hide(const Cone& face, const Cone& by, bool nearer, Scratch& scratch) const;

    std::vector<Vector3> vertices_;
    std::vector<Triangle> triangles_;
    double size_ = 0.0; ///< of the cage
    std::vector<float> directions_; ///< all x, then all y, then all z; z rises in even steps from -1 to 1
};

struct VisibleCage::Cone
{
    Triangle vertex;
    Vector3 a, b, c; ///< corners relative to the point
    Vector3 normal; ///< not of unit length
    double plane, volume; ///< normal . p for points p of the face; a . (b x c)
    Vector3 side[3]; ///< normals of the side planes opposite a, b, c, which look into the cone
};

struct VisibleCage::Scratch
{
    /// A convex polygon in a cone. A cut adds one corner at most; a polygon without room for that is split
    /// first.
    struct Piece
    {
        static constexpr int most = 24;
        Vector3 corner[most];
        int size = 0;

        Piece() = default;
        Piece(const Piece& other) { *this = other; }
        Piece& operator=(const Piece& other) // NOLINT(bugprone-unhandled-self-assignment): gives the same
        {
            size = other.size;
            for (int i = 0; i < size; ++i)
                corner[i] = other.corner[i];
            return *this;
        }
        void add(const Vector3& p) { corner[size++] = p; }
    };

    std::vector<Cone> back_faces, front_faces;
    std::vector<std::size_t> candidates; ///< the front faces that may hide a back face
    std::vector<Triangle> hiding; ///< the corners of the front faces, by number
    std::vector<int> number; ///< of the vertices of front faces; -1 for others
    std::vector<float> sight; ///< x, y, z of the unit vectors to the numbered vertices, then of the vectors
    std::vector<int> beyond; ///< per numbered vertex: see CageKernels::beyond_planes
    std::vector<Piece> pieces, next;
    AlignedVector<double> arcs, integrals; ///< see CageKernels::arc_integrals
    int arc_count = 0;
    std::vector<int> last_arcs; ///< where the arcs of each back face end

    void add_arcs(const Piece& piece);
    std::vector<float> nearest; ///< 1 / distance of the first back face along each ray
    std::vector<int> first; ///< that face, or -1
};

} // namespace sinew
