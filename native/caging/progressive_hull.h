// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/caging/fineness.h"
#include "native/caging/wrap.h"
#include "native/core/progress.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <array>
#include <queue>
#include <tuple>
#include <vector>

namespace sinew {

/// A closed surface that becomes coarser while it keeps enclosing what it enclosed.
///
/// P. Sander et al. "Silhouette Clipping." SIGGRAPH 2000, section 3: progressive hulls. An edge is collapsed
/// to the point outside all planes of the faces around it that is closest to them: with areas A, planes n.p =
/// d and the edge's middle m, it minimises sum A (n.p - d)^2 + 0.03 sum A |p - m|^2 under n.p >= d. Departs
/// from the paper: after a collapse the surface must also be free of crossings, no normal may have turned by
/// more than 78 degrees, no triangle may be too thin, and no vertex may have less than one steradian inside.
/// This keeps thin limbs apart and the cage usable.
///
/// One half of a mirror-symmetric surface may be given: its vertices on the mirror have the coordinate 0
/// along `mirror_axis` and keep it, all others stay on the positive side, so that the half and its mirror
/// image together do not cross.
class ProgressiveHull
{
public:
    /// \param size         the size of the target, with which lengths are compared
    /// \param mirror_axis  0 to 2, or -1 for a whole surface
    /// \param fineness     how fine it becomes where
    ProgressiveHull(TriangleSoup surface, double size, int mirror_axis = -1, Fineness fineness = {});

    /// Collapses edges, cheapest first, until `faces` faces remain or no edge may be collapsed. Equal
    /// surfaces give equal results.
    /// \param boldly  normals may turn by up to 120 degrees, and a vertex may be a spike
    ///                far from its edge
    void collapse(int faces, bool boldly, const Progress& progress);

    /// Lowers the enclosed volume plus 0.05 L times the sum of the squared lengths of the edges, where L is
    /// their mean length: the first keeps the surface close to `within`, which it encloses, and the second
    /// pulls in spikes and spaces the vertices. Moves vertices and turns edges, round after round until
    /// nothing changes, as long as the surface touches neither `within` nor itself.
    void tighten(const TriangleTree& within, int rounds, const Progress& progress);

    int face_count() const { return face_count_; }

    /// The remaining vertices and faces, in their first order.
    TriangleSoup surface() const;

private:
    using Box = Eigen::AlignedBox3d;
    struct Candidate
    {
        double cost;
        int a, b, stamp;
        Vector3 point;

        // The queue returns the greatest candidate, which shall be the cheapest; ties go by the vertices.
        bool operator<(const Candidate& o) const { return std::tie(o.cost, o.a, o.b) < std::tie(cost, a, b); }
    };
    /// The triangles around a vertex as they will be after a move.
    struct Fan
    {
        std::vector<Corners> corners;
        std::vector<Triangle> indices;
    };

    std::vector<int> ring(int vertex) const;
    std::vector<int> faces_around(int a, int b) const;
    Vector3 area(int face) const;
    bool on_mirror(int vertex) const { return mirror_axis_ >= 0 && points_[vertex][mirror_axis_] == 0.0; }
    void propose(int a, int b);
    bool may_collapse(const Candidate& edge);
    void collapse(const Candidate& edge);
    bool may_move(int vertex, const Vector3& to, const TriangleTree& within);
    bool stays_embedded(const Fan& fan, const std::vector<int>& replaced);
    double solid_angle(const Fan& fan, int vertex, bool on) const;
    bool keeps_mirror(const Fan& fan, int vertex, bool on) const;
    bool relax(int vertex, double stiffness, const TriangleTree& within);
    bool flip(int a, int b, double stiffness, const TriangleTree& within);
    void renew_box(int face);
    void renew_boxes();

    std::vector<Vector3> points_;
    std::vector<Triangle> faces_;
    std::vector<char> alive_;
    std::vector<std::vector<int>> around_; ///< faces at each vertex
    std::vector<Box> boxes_;
    std::vector<int> live_; ///< faces alive at the last renew_boxes()
    std::vector<int> stamps_;
    std::vector<char>
        restless_; ///< vertices that tightening may still move: they or their neighbours did move
    std::priority_queue<Candidate> queue_;
    double size_;
    int mirror_axis_;
    Fineness fineness_;
    bool bold_ = false;
    int face_count_;
};

} // namespace sinew
