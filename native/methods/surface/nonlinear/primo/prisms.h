// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/bodies/rigid_bodies.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <span>
#include <vector>

namespace sinew {

/// What the prisms have from the shape that they are to keep.
struct PrismShape
{
    Points points;      ///< (n, 3) the vertices
    Points centres;     ///< (bodies, 3)
    Points area;        ///< (bodies, 3) the area vectors of the faces, zero for vertices
    Points normals;     ///< (n, 3) of unit length or zero
};

/// A prism for each face of the parts with a handle, which stands on the face along the normals of its
/// corners, and a body for each vertex that handles hold or pull. The prisms are joined
///
///   - where two faces share an edge (where more do, each with up to four others of them);
///   - where faces share a vertex, but no chain of such edges at this vertex joins them;
///   - with the bodies of their corners.
///
/// A prism all of whose corners are held exactly is held itself.
class Prisms
{
public:
    /// \param mesh     at rest.
    /// \param height   (n) at each vertex, above and below the surface.
    Prisms(const SurfaceMesh& mesh, const Regions& regions, std::vector<double> height);

    int size() const { return static_cast<int>(handles_.size()); }
    /// The handle that holds a body, or -1.
    int handle(int body) const { return handles_[body]; }
    std::span<const int> corners(int body) const
    {
        return {corners_.data() + first_corner_[body], corners_.data() + first_corner_[body + 1]};
    }
    bool is_vertex(int body) const { return first_corner_[body + 1] - first_corner_[body] == 1; }
    /// The prisms at a vertex.
    std::span<const int> prisms_at(int vertex) const
    {
        return {prisms_at_.data() + first_prism_[vertex], prisms_at_.data() + first_prism_[vertex + 1]};
    }
    /// The body of a vertex that handles hold or pull, or -1.
    int body_of(int vertex) const { return body_of_[vertex]; }

    /// The bodies as nodes, and the weights of their joints.
    HandleGraph graph(const Regions& regions) const;
    /// From now on, body old[b] has the number b.
    void renumber(const std::vector<int>& old);
    std::vector<BodyJoint> joints() const;

    void set_shape(const PointsView& points, PrismShape& shape) const;
    /// The area vector of a body's face on other points, and that of a polygon.
    Vector3 area(const PointsView& points, int body) const;
    static Vector3 area(const Points& corners);
    /// What the energy needs of a joint.
    JointShape joint_shape(int joint, const PrismShape& shape) const;

private:
    struct Joint
    {
        int body[2], end[2]; ///< the ends of the edge; one vertex twice where a joint is no edge
        double weight;
    };
    void add_body(std::span<const int> corners, int handle);
    void join_at_edges(const SurfaceMesh& mesh, const std::vector<int>& faces);
    void join_at_vertices();
    void add_vertices(const Regions& regions);

    std::vector<double> height_;
    std::vector<int> handles_, first_corner_{0}, corners_, first_prism_, prisms_at_, body_of_;
    std::vector<Joint> joints_;
    double typical_ = 1.0; ///< the median of the weights
};

} // namespace sinew
