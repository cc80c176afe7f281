// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/enclosure/wrap.h"
#include "native/mesh/triangle_tree.h"

#include <Eigen/Geometry>

#include <array>
#include <queue>
#include <tuple>
#include <vector>

namespace sinew {

/// A closed surface that is made coarser while it keeps enclosing what it enclosed.
///
/// P. Sander et al. "Silhouette Clipping." SIGGRAPH 2000, section 3: progressive hulls. An edge is collapsed
/// to the point outside all planes of the faces around it that is closest to them: with areas A, planes n.p =
/// d and the edge's middle m, it minimises sum A (n.p - d)^2 + 1e-3 sum A |p - m|^2 under n.p >= d. Departs
/// from the paper: a collapse must also keep the surface embedded, the normals within 78 degrees and the
/// triangles' shapes, which keeps thin limbs apart and the cage usable.
///
/// Half of a mirror-symmetric surface may be given: vertices flagged as `on_mirror` have the coordinate 0
/// along `mirror_axis` and stay there, all others stay on its positive side, so that the half and its image
/// make an embedded whole.
class ProgressiveHull
{
public:
    /// \param size         what lengths are compared with
    /// \param mirror_axis  0 to 2, or -1 for a whole surface
    ProgressiveHull(TriangleSoup surface, double size, int mirror_axis = -1);

    /// Collapses edges, cheapest first, until `faces` are left or nothing may be collapsed any more.
    /// Deterministic.
    void collapse(int faces, const Progress& progress);

    /// Pulls the vertices towards `within`, which the surface encloses, and evens them out, as long as
    /// neither is touched: four rounds.
    void tighten(const TriangleTree& within, const Progress& progress);

    int face_count() const { return face_count_; }

    /// What is left, in the order of the first vertices and faces.
    TriangleSoup surface() const;

private:
    using Box = Eigen::AlignedBox3d;
    struct Candidate
    {
        double cost;
        int a, b, stamp;
        Vector3 point;

        // The queue gives the greatest: the cheapest here, and one order among equals.
        bool operator<(const Candidate& o) const { return std::tie(o.cost, o.a, o.b) < std::tie(cost, a, b); }
    };
    /// Triangles that a move makes, with the vertices they will have.
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
    bool keeps_mirror(const Fan& fan, int vertex, bool on) const;
    void renew_boxes();

    std::vector<Vector3> points_;
    std::vector<Triangle> faces_;
    std::vector<char> alive_;
    std::vector<std::vector<int>> around_; ///< faces at each vertex
    std::vector<Box> boxes_;
    std::vector<int> live_; ///< faces alive at the last renew_boxes()
    std::vector<int> stamps_;
    std::priority_queue<Candidate> queue_;
    double size_;
    int mirror_axis_;
    int face_count_;
};

} // namespace sinew
