// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/simd/aligned.h"
#include "native/space/cage/cage.h"

#include <vector>

namespace sinew {

/// What points inside a cage see of it, and the mean value integrals over that.
///
/// From inside, faces that are left (seen from behind) alone can come first, and faces that are entered alone
/// hide them. The cone of each face that is left is cut by the side planes of those that hide it; the
/// integral of the unit direction over a spherical polygon is half the sum of arc angle times arc normal, and
/// that over the pieces of a triangle is shared among its corners so that sum_i w_i (v_i - x) is the
/// integral.
class VisibleCage
{
public:
    /// \param directions  rays of sampled(), in antipodal pairs; 0 for none.
    VisibleCage(const Cage& cage, int directions);
    ~VisibleCage();

    bool directed() const { return !directions_.empty(); }

    struct Scratch; ///< memory of one thread
    /// Adds the weights of x, strictly inside, not yet of sum one, to row (c).
    void exact(const Vector3& x, Scratch& scratch, double* row) const;
    /// The same by rays.
    void sampled(const Vector3& x, Scratch& scratch, double* row) const;

private:
    struct Cone;

    void look(const Vector3& x, Scratch& scratch) const;
    void sort_vertices(const Cone& face, Scratch& scratch) const;
    void hide(const Cone& face, const Cone& by, bool nearer, Scratch& scratch) const;

    std::vector<Vector3> vertices_;
    std::vector<Triangle> triangles_;
    double size_ = 0.0;             ///< of the cage
    std::vector<float> directions_; ///< all x, then all y, then all z, which grow evenly from -1 to 1
};

struct VisibleCage::Cone
{
    Triangle vertex;
    Vector3 a, b, c;      ///< corners seen from the point
    Vector3 normal;       ///< not of unit length
    double plane, volume; ///< normal . p on the face; a . (b x c)
    Vector3 side[3];      ///< opposite a, b, c; a positive product with each is within the cone
};

struct VisibleCage::Scratch
{
    /// A convex cone polygon. Cuts add a corner at most each; a full one is split first.
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

    std::vector<Cone> left, entered;
    std::vector<std::size_t> candidates; ///< those of `entered` that may hide a face
    std::vector<Triangle> hiding;        ///< the corners of `entered`, by number
    std::vector<int> number;      ///< of the vertices of `entered`; -1 for others
    std::vector<float> sight; ///< x, y, z of the unit vectors to the numbered vertices, then of the vectors
    std::vector<int> beyond;  ///< a numbered vertex: bits of the planes of a face that it is beyond
    std::vector<Piece> pieces, next;
    AlignedVector<double> arcs, integrals; ///< see CageKernels::arc_integrals
    int arc_count = 0;
    std::vector<int> last_arcs; ///< of each of `left`: where those of the next begin

    void add_arcs(const Piece& piece);
    std::vector<float> nearest; ///< 1 / distance of the first face along each direction
    std::vector<int> first;
};

} // namespace sinew
